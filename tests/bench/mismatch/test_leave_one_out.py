"""Leaving a known term out: would it have been found?"""

from __future__ import annotations

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
    for effect in ("friction.coulomb", "motor.inertia"):
        assert "| named (" in rows[f"`{effect}`"], rows[f"`{effect}`"]
    # the inertia that A. Janot and others publish for EMPS is 95.1 kg
    assert "J = 94" in rows["`motor.inertia`"] or "J = 95" in rows["`motor.inertia`"]
    assert "contiguous blocks" in result.output
