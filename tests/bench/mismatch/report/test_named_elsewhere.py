"""What one channel shows without a name, and an effect named in another channel explains, is that effect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.report.finding import conclude
from tests.bench.mismatch.report import made


@pytest.mark.parametrize(
    ("alternative", "as_good", "status", "findings"),
    [
        ("load.unbalance", True, "named", 1),
        ("load.unbalance", False, "named", 2),
        ("friction.stribeck", True, "named", 2),
        ("load.unbalance", True, "ambiguous", 2),
    ],
)
def test_what_a_named_effect_explains_as_well_is_no_second_finding(
    alternative: str, as_good: bool, status: str, findings: int
) -> None:
    frame = made.campaign()
    arm = np.sin(frame.q)
    named = made.discovery("load_torque", "load.unbalance", 4.0 * arm, ("angle",), status=status)
    load = made.outcome(frame, "load_torque", [named], 1.0)
    # far stronger over its own noise floor: the name is told all the same
    nameless = made.discovery("motor_torque", "unknown", 0.4 * arm, ("angle",))
    motor = made.outcome(frame, "motor_torque", [nameless], 0.02)
    motor.discoveries = [replace(nameless, alternatives=(made.alternative(alternative, motor.left, as_good),))]

    concluded = conclude([load, motor], made.dataset(frame, "load_torque", load.rows))

    assert sorted(f.effect for f in concluded) == ["load.unbalance", "unknown"][:findings]
    (first,) = (f for f in concluded if f.effect == "load.unbalance")
    assert first.channel == "load_torque"
    assert first.also_in == (("motor_torque",) if findings == 1 else ())
