"""A tone that several channels have is one finding; tones of different frequencies are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.report.finding import conclude
from tests.bench.mismatch.report import made

HALF_LINE = 0.05
FRAME = made.campaign()


def outcome(channel: str, frequency: float, floor: float) -> ChannelOutcome:
    tone = {"symbol": "f", "value": frequency, "unit": "Hz", "std": HALF_LINE / np.sqrt(3.0)}
    size = {"symbol": "a", "value": floor, "unit": "", "std": 0.01 * floor}
    found = made.discovery(channel, "unknown", np.full(FRAME.size, floor), ("time",))
    return made.outcome(FRAME, channel, [replace(found, parameters=(tone, size))], floor)


@pytest.mark.parametrize(("other", "findings"), [(17.3, 1), (17.35, 1), (17.4, 1), (17.5, 2)])
def test_a_tone_in_two_channels_is_one_finding(other: float, findings: int) -> None:
    both = [outcome("transmission_error", 17.3, 1e-6), outcome("motor_torque", other, 0.02)]
    concluded = conclude(both, made.dataset(FRAME, "motor_torque", both[1].rows))
    assert len(concluded) == findings
    shown = {concluded[0].channel, *concluded[0].also_in}
    assert len(shown) == 3 - findings


def test_a_function_of_something_recorded_is_no_tone() -> None:
    tone = outcome("transmission_error", 17.3, 1e-6)
    function = made.discovery("motor_torque", "unknown", np.full(FRAME.size, 0.02), ("time",))
    other = made.outcome(FRAME, "motor_torque", [function], 0.02)
    assert len(conclude([tone, other], made.dataset(FRAME, "motor_torque", other.rows))) == 2


def test_a_tone_beside_something_else_without_a_name_keeps_its_recordings() -> None:
    """A tone adds nothing that can be predicted; what counts of it is not lost where another finding joins it."""
    nothing, loud = np.zeros(FRAME.size), np.where(FRAME.recording == 1, 0.02, 0.0)
    tone = replace(made.discovery("motor_torque", "unknown", nothing, ("time",)), excess=loud)
    bursts = made.discovery("motor_torque", "unknown", nothing, ("time",))
    own = made.outcome(FRAME, "motor_torque", [tone, bursts], 0.02)
    (found,) = conclude([own], made.dataset(FRAME, "motor_torque", own.rows))
    assert len(found.location.recordings) == 1
