"""``bench trend`` in a shell."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import BenchError
from bench.trend import trend
from tests.bench.trend.conftest import GEARBOX


def test_the_three_lines_come_first_and_the_table_after(root: Path) -> None:
    done = CliRunner().invoke(make_app(), ["trend", str(root), "--gearbox", GEARBOX])
    assert done.exit_code == 0, done.output
    assert done.output.index("Since month-6: 2 of") < done.output.index("last campaign of each quantity")
    assert "hysteresis" in done.output
    assert "nan" not in done.output


def test_several_gearboxes_have_to_be_chosen_from(root: Path) -> None:
    with pytest.raises(BenchError, match=r"several gearboxes: RH-7 \(3 campaigns\), RH-9 \(1 campaigns\)"):
        CliRunner().invoke(make_app(), ["trend", str(root)], catch_exceptions=False)
    with pytest.raises(BenchError, match="should be a date"):
        CliRunner().invoke(make_app(), ["trend", str(root), "--since", "May"], catch_exceptions=False)


def test_the_library_and_json_say_the_same(root: Path) -> None:
    done = CliRunner().invoke(make_app(), ["trend", str(root), "--gearbox", GEARBOX, "--no-identify", "--json"])
    assert json.loads(done.stdout) == json.loads(json.dumps(trend(root, GEARBOX).as_dict()))
