"""Names that become files and folders, at every edge where one comes in."""

from pathlib import Path
from typing import Any

import h5py
import pytest
from typer.testing import CliRunner

from bench.campaigns import Block, Campaign, Stage, load_campaign, parse_campaign
from bench.cli.app import make_app
from bench.errors import ConfigurationError, RecordingError
from bench.names import LONGEST, require_name, why_no_name
from bench.service.data.recordings import UnknownPlace, inside
from tests.bench.recording import builders

PATHS = ("", "  ", ".", "..", "../x", "a/b", "a\\b", ".hidden", " a", "a ", "x" * (LONGEST + 1))
BAD = (*PATHS, "a\0b", "a\nb", "a\x1b[31m", "\u202ea", "\ud800")


@pytest.mark.parametrize("name", BAD)
def test_what_could_lead_elsewhere_or_say_something_else_is_no_name(name: str, tmp_path: Path) -> None:
    assert why_no_name(name)
    with pytest.raises(ConfigurationError) as caught:
        Campaign(name, "title", (Stage("s", (Block("dwell"),)),))
    assert str(caught.value).isprintable()
    with pytest.raises(UnknownPlace):
        inside(tmp_path, name)


@pytest.mark.parametrize("name", ["quick", "Getriebe 7, 50 °C", "a..b", "x" * LONGEST, "0001-dwell-take2", "回転"])
def test_ordinary_names_pass(name: str) -> None:
    assert require_name(name, "it") == name


@pytest.mark.parametrize("value", [None, 7, b"x"])
def test_what_is_no_text_is_no_name(value: Any) -> None:
    assert "no text" in str(why_no_name(value))


def test_a_campaign_file_that_names_another_folder_is_refused() -> None:
    text = "\n".join(
        (
            'format = "bench-campaign"',
            'format_version = "1.0"',
            'name = "../../etc/x"',
            'title = "t"',
            "[[stages]]",
            'name = "s"',
            "[[stages.points]]",
            'sequence = "dwell"',
        )
    )
    with pytest.raises(ConfigurationError, match=r'c\.toml: the campaign name "../../etc/x" holds a slash'):
        parse_campaign(text, "c.toml")
    assert load_campaign("quick").name == "quick"


@pytest.mark.parametrize("name", ["../elsewhere", "/tmp/elsewhere", "a\x1b[31mb"])
def test_export_writes_nowhere_but_where_it_was_told(tmp_path: Path, name: str) -> None:
    path = builders.write(tmp_path / "a.h5", rows=400)
    with h5py.File(path, "r+") as file:
        file.attrs["recording_id"] = name
    result = CliRunner().invoke(make_app(), ["export", str(path), "--to", "csv", "--out", str(tmp_path / "in" / "out")])
    assert isinstance(result.exception, RecordingError)
    assert "a.h5: the recording id" in str(result.exception)
    assert not list(tmp_path.rglob("*.csv"))
