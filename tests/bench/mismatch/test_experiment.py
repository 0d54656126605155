"""The next experiment: accepted by the bench, within its limits, and it separates the rivals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.campaigns import load_campaign, make_plan
from bench.configuration import load_bench
from bench.mismatch.assess import assess
from bench.mismatch.candidates import Candidate, Range, candidates, frame_of
from bench.mismatch.experiment import campaign, propose, separating
from bench.mismatch.findings import Finding
from bench.mismatch.given import Given
from bench.simulation.model import Simulation
from tests.bench.mismatch.synthetic import COVERED, RATIO, effect, torques


def _without_slow_speeds() -> tuple[Finding, object, object]:
    """Churning where only the upper speeds were run: Stribeck friction explains it nearly as well."""
    data = torques(
        lambda f: effect("friction.viscous_quadratic", "motor_torque", "square", f, (0.06,), ()),
        speeds=(0.1, 0.14, 0.17),
    )
    found = assess(data, Given.of(Simulation.nominal()), ("motor_torque",))
    finding = next(f for f in found.findings if f.effect in ("friction.viscous_quadratic", "friction.stribeck"))
    return finding, found, data


def test_slow_speeds_are_asked_for_where_they_tell_two_laws_apart() -> None:
    finding, found, data = _without_slow_speeds()
    model, source = found.analysis.models["motor_torque"], finding.source  # type: ignore[attr-defined]
    rival = next(a for a in source.alternatives if a.entry.effect.startswith("friction."))
    # whatever the noise let the search say, these two shall be told apart
    source = replace(source, alternatives=[replace(rival, loss=0.0, error=1.0, contains=False)], gain=1e6)
    proposal = separating(model, source, Range.of(data), RATIO)  # type: ignore[arg-type]
    assert proposal is not None
    slowest = min(abs(p.velocity) for p in proposal.points)
    assert any(p.sequence == "velocity_ramp" for p in proposal.points) or slowest < 0.1
    assert "differ most" in proposal.why


def test_the_file_is_a_campaign_within_the_limits(tmp_path: Path) -> None:
    finding, found, data = _without_slow_speeds()
    finding.status = "ambiguous"
    propose(finding, found.analysis, tmp_path, 1, data)  # type: ignore[attr-defined, arg-type]
    assert finding.next_experiment is not None
    plan = make_plan(load_campaign(tmp_path / finding.next_experiment["file"]), load_bench("rh380n").configuration)
    assert plan.points == len(finding.next_experiment["points"])


def test_every_candidate_can_be_planned(tmp_path: Path) -> None:
    listed = list(candidates(replace(COVERED, warmest=30.0)))
    assert {c.sequence for c in listed} == {"constant_velocity", "reversal", "torque_ramp", "velocity_ramp"}
    some = [listed[i] for i in np.linspace(0, len(listed) - 1, 12).astype(int)]
    path = tmp_path / "all.toml"
    path.write_text(campaign("all", 1, some), encoding="utf-8")
    assert make_plan(load_campaign(path), load_bench("rh380n").configuration).points == len(some)


@pytest.mark.parametrize("candidate", list(candidates(COVERED))[::17], ids=lambda c: f"{c.sequence} {c.torque:g}")
def test_a_candidates_rows_are_its_motion(candidate: Candidate) -> None:
    frame = frame_of(candidate, COVERED, RATIO)
    assert np.abs(frame.velocity).max() == pytest.approx(abs(candidate.velocity))
    assert np.abs(frame.torque).max() == pytest.approx(abs(candidate.torque))
    assert np.all(np.diff(frame.travel) > 0)
    if candidate.sequence == "reversal":
        assert set(frame.last_direction) == {1.0, -1.0}
        assert frame.reversed_before.max() == 1.0
