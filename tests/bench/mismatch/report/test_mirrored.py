"""A load that the torque sensor misreads shows twice, and is one finding."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.report.finding import conclude
from bench.mismatch.report.mirrored import mirrored
from tests.bench.mismatch.report import made


@pytest.mark.parametrize(("share", "findings"), [(-1.0, 1), (-0.8, 1), (1.0, 2), (-0.4, 2)])
def test_what_the_motor_torque_lacks_of_a_misread_load_is_no_second_finding(share: float, findings: int) -> None:
    frame = made.campaign()
    jump = np.where((frame.time > 3000.0) & (frame.time < 6000.0), 11.0, 0.0)
    load = made.outcome(frame, "load_torque", [made.discovery("load_torque", "unknown", jump, ("time",))], 1.0)
    shown = share * jump / made.RATIO
    motor = made.outcome(frame, "motor_torque", [made.discovery("motor_torque", "unknown", shown, ("time",))], 0.02)
    assert mirrored([load, motor], made.RATIO) is (findings == 1)
    data = made.dataset(frame, "load_torque", load.rows)
    concluded = conclude([load, motor], data)
    assert len(concluded) == findings
    assert concluded[0].channel == "load_torque"
    assert concluded[0].also_in == (("motor_torque",) if findings == 1 else ())


def test_without_both_channels_nothing_is_mirrored() -> None:
    frame = made.campaign()
    found = made.discovery("load_torque", "unknown", np.ones(frame.size), ("time",))
    load = made.outcome(frame, "load_torque", [found], 1.0)
    assert not mirrored([load], made.RATIO)
    assert not mirrored([load, made.outcome(frame, "motor_torque", [], 0.02)], made.RATIO)
