"""Texts of files on the terminal: shown, not obeyed."""

from __future__ import annotations

import io
import json
from pathlib import Path

import h5py
import pytest
from rich.table import Table
from typer.testing import CliRunner

from bench.cli._plain import PlainConsole, escaped, line, plain, say
from bench.cli.app import make_app
from tests.bench.recording import builders

HOSTILE = "\x1b]0;owned\x07\x1b[2J$\\frac[red]all is well[/red][/]$\x9b1A\u202eevil\nvalid"


def test_what_steers_a_terminal_is_written_out() -> None:
    assert plain("a\x1b[2Jb\x7f\x9b\u202ec\td\n") == "a\\u001b[2Jb\\u007f\\u009b\\u202ec\td\n"
    assert line("a\nb") == "a\\nb"


@pytest.mark.parametrize("terminal", [True, False])
def test_a_console_obeys_only_its_own_styles(terminal: bool) -> None:
    out = io.StringIO()
    console = PlainConsole(file=out, force_terminal=terminal, width=400, color_system="truecolor", highlight=False)
    table = Table()
    table.add_column("name")
    table.add_row(escaped(HOSTILE))
    console.print(table)
    console.print(f"[bold]{escaped(HOSTILE)}[/]")
    console.print(HOSTILE, markup=False)
    shown = out.getvalue().replace("\x1b[1m", "").replace("\x1b[0m", "").replace("\x1b[1;", "")
    assert "\x1b]" not in shown
    assert "\x1b[2J" not in shown
    assert not set("\x07\x9b\u202e") & set(shown)
    assert shown.count("[red]all is well[/red][/]$") == 3


def test_json_stays_json(capsys: pytest.CaptureFixture[str]) -> None:
    say(json.dumps({"text": HOSTILE}, ensure_ascii=False))
    shown = capsys.readouterr().out
    assert json.loads(shown) == {"text": HOSTILE}
    assert not set("\x1b\x07\x9b\u202e") & set(shown)


@pytest.mark.parametrize("command", [("inspect", "--no-plot"), ("inspect",), ("validate", "--notes")])
def test_the_commands_on_recordings_obey_no_file(tmp_path: Path, command: tuple[str, ...]) -> None:
    path = builders.write(tmp_path / "a.h5", campaign_id=HOSTILE)
    with h5py.File(path, "r+") as file:
        file.attrs["kind"] = HOSTILE.replace("\x00", "")
        file["events/text"][0] = HOSTILE
        file["channels/cycle"].attrs["unit"] = HOSTILE
    result = CliRunner().invoke(make_app(), [*command, str(path)])
    assert result.exit_code == 6, result.output
    assert not set("\x1b\x07\x9b\u202e") & set(result.output)
    assert "\nvalid" not in result.output
    assert "all is well" in result.output
