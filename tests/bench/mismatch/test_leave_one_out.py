"""Nominal terms switched off in turn: asked of made-up torques, and of real recordings where they are at hand."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.mismatch.assess import Assessment, assess
from bench.mismatch.channels import Analysis
from bench.mismatch.given import Given
from bench.mismatch.leave_one_out import NAMED, NOT_ASKED, leave_one_out, table
from bench.simulation.model import Simulation, Term
from tests.bench.mismatch.synthetic import temperatures, torques, transmission

REAL = Path(__file__).parents[4] / "shared" / "real" / "emps"
"""EMPS of A. Janot, M. Gautier and M. Brunot (2019), not part of the project"""


def test_terms_of_the_torque_balances_are_named() -> None:
    data, channels = torques(), ("motor_torque", "load_torque")
    model = Simulation.nominal().with_term(Term("motor.inertia", False))
    whole = assess(data, Given.of(model), channels)
    asked = ("friction.coulomb", "load.bearing_friction", "motor.inertia", "te.offset")
    told: list[str] = []
    rows = leave_one_out(data, model, channels, whole, Path(), lambda what, _: told.append(what), effects=asked)
    answers = {row.effect: row for row in rows}
    assert told == list(asked) == list(answers)
    for effect in asked[:2]:
        assert answers[effect].outcome == NAMED, answers[effect]
    assert float(answers["friction.coulomb"].parameters.split()[2]) == pytest.approx(0.5, abs=0.002)
    assert answers["motor.inertia"].why == "already switched off in the simulation given"
    assert answers["te.offset"].outcome == NOT_ASKED
    assert "| `friction.coulomb` | motor_torque | named (" in table(rows)


@pytest.mark.parametrize(
    ("term", "channel", "said"),
    [
        ("te.fourier", "transmission_error", "te.harmonic"),
        ("thermal.loss_heating", "temperature", "thermal.loss_heating"),
    ],
)
def test_terms_of_the_other_channels_are_named(term: str, channel: str, said: str) -> None:
    data = temperatures() if channel == "temperature" else transmission(turns=12)
    model = Simulation.nominal().with_term(Term("te.fourier", True, {}, (1.0, 46.0, 92.0)))
    whole = Assessment(Analysis(), {}, [])
    (row,) = leave_one_out(data, model, (channel,), whole, Path(), lambda _what, _share: None, effects=(term,))
    assert row.outcome == NAMED, row
    assert row.said[0] == said


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
    for effect in ("friction.coulomb", "friction.viscous", "motor.inertia"):
        assert "| named (" in rows[f"`{effect}`"], rows[f"`{effect}`"]
    assert "f_c = 21" in rows["`friction.coulomb`"] or "f_c = 20" in rows["`friction.coulomb`"]
    assert "contiguous blocks" in result.output
