"""``bench doctor`` as a user and a script call it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app


@pytest.mark.parametrize(("options", "code"), [((), {0, 6}), (("--bus", "no-such-port"), {6})])
def test_findings_are_for_scripts(tmp_path: Path, options: tuple[str, ...], code: set[int]) -> None:
    done = CliRunner().invoke(make_app(), ["doctor", "--out", str(tmp_path), "--json", *options])
    assert done.exit_code in code
    found = json.loads(done.stdout)
    assert found["fit"] == (done.exit_code == 0)
    assert all(entry["change"] for entry in found["findings"] if entry["state"] != "good")


def test_findings_are_for_people(tmp_path: Path) -> None:
    done = CliRunner().invoke(make_app(), ["doctor", "--out", str(tmp_path), "--bus", "no-such-port"])
    assert done.exit_code == 6
    assert "no-such-port" in done.stdout
    assert "real-time scheduling" in done.stdout
