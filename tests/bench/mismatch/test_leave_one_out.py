"""Leaving a known term out: would it have been found?"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app

REAL = Path(__file__).parents[4] / "shared" / "real" / "emps"
"""EMPS of A. Janot, M. Gautier and M. Brunot (2019), not part of the project"""


@pytest.mark.skipif(not REAL.is_dir(), reason="the EMPS recordings (../shared/real/emps) are not here")
def test_would_coulomb_friction_have_been_found_in_emps(tmp_path: Path) -> None:
    runner = CliRunner()
    mapping = str(Path(__file__).parents[3] / "docs" / "examples" / "emps.toml")
    folder, out = str(tmp_path / "emps"), str(tmp_path / "report")
    imported = runner.invoke(make_app(), ["import", mapping, "--data", str(REAL), "--out", folder])
    assert imported.exit_code == 0, imported.output
    result = runner.invoke(make_app(), ["mismatch", folder, "--out", out, "--leave-one-out"])
    assert result.exit_code == 0, result.output
    rows = {line.split("|")[1].strip(): line for line in result.output.splitlines() if line.startswith("| `")}
    assert "| named (" in rows["`motor.inertia`"], rows["`motor.inertia`"]
    # a friction that bends over with speed is there as well, and Coulomb's may be a Stribeck curve of a wide speed
    assert "| named (" in rows["`friction.coulomb`"] or "| ambiguous (" in rows["`friction.coulomb`"]
    # A. Janot and others publish 95.1 kg and 20.4 N for EMPS
    for effect, symbol, published, within in (
        ("motor.inertia", "J", 95.1, 1.0),
        ("friction.coulomb", "f_c", 20.4, 1.0),
    ):
        told = re.search(rf"{symbol} = ([\d.]+)", rows[f"`{effect}`"])
        assert told is not None
        assert abs(float(told[1]) - published) < within
    assert "contiguous blocks" in result.output
