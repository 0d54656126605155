"""Motion by hand: slow, without load, at low torque, and at rest without torque as soon as nobody holds it."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.campaigns.operator.gentle import gentle, greatest_speed
from bench.campaigns.operator.jog import jog
from bench.configuration import BenchFile, load_bench
from bench.cycle.channels import Scaling
from bench.cycle.end import EndKind
from bench.cycle.view import View
from bench.errors import LimitError
from bench.protocols import Segment
from bench.safety import Cause
from bench.safety.acts import latch_of
from bench.stop_button import StopButton


@pytest.fixture(scope="module")
def file() -> BenchFile:
    return load_bench("rh380n")


class Seen:
    """Angles and set speeds of every row."""

    def __init__(self) -> None:
        self.angle: list[NDArray[Any]] = []
        self.speed: list[NDArray[Any]] = []

    def opened(self, view: View) -> None:
        pass

    def begin(self, scaling: Scaling, bench_time: Any, what: str) -> None:
        self.scaling = scaling

    def segment(self, segment: Segment | None) -> None:
        pass

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        self.angle.append(raw["load_angle"] * self.scaling.scale("load_angle"))
        self.speed.append(raw["motor_velocity_setpoint"] * self.scaling.scale("motor_velocity_setpoint"))


def turned(file: BenchFile, folder: Path, asked: int, velocity: float, button: StopButton | None = None) -> Any:
    seen, left = Seen(), [asked]

    def held() -> bool:
        left[0] -= 1
        return left[0] >= 0

    moved: list[str] = []
    end = jog(
        file,
        folder,
        velocity,
        held,
        button or StopButton("by hand"),
        tap=seen,
        moving=lambda: moved.append("moving"),
        real_time=False,
    )
    return end, seen, moved


def test_it_turns_while_held_and_rests_when_let_go(file: BenchFile, tmp_path: Path) -> None:
    velocity = -0.5 * greatest_speed(file.configuration)
    end, seen, moved = turned(file, tmp_path, 6, velocity)
    assert (end.kind, end.cause) == (EndKind.INTERRUPTED, Cause.OPERATOR)
    assert moved == ["moving"]
    angle, speed = np.concatenate(seen.angle), np.concatenate(seen.speed)
    assert -math.pi < angle[-1] - angle[0] < -1e-3
    assert np.abs(speed).max() == pytest.approx(abs(velocity) * file.configuration.gearbox.ratio, rel=1e-3)
    # no latch: to let go is no stop that has to be acknowledged
    assert list(tmp_path.iterdir()) == []


def test_nothing_moves_before_it_is_held_or_after_stop(file: BenchFile, tmp_path: Path) -> None:
    end, seen, moved = turned(file, tmp_path, 0, 0.01)
    assert "nothing has moved" in end.text
    button = StopButton("by hand")
    button.press("somebody")
    end, more, again = turned(file, tmp_path, 100, 0.01, button)
    assert "nothing has moved" in end.text
    assert seen.angle == more.angle == []
    assert moved == again == []


def test_its_limits_are_lower_and_the_others_stay(file: BenchFile) -> None:
    usual, low = file.configuration.limits, gentle(file).configuration.limits
    assert low.motor_torque == pytest.approx(0.25 * usual.motor_torque)
    assert low.motor_speed == pytest.approx(1.25 * 0.05 * usual.motor_speed)
    assert low.model_copy(update={"motor_torque": usual.motor_torque, "motor_speed": usual.motor_speed}) == usual
    assert file.configuration.limits == usual


@pytest.mark.parametrize("share", [0.0, 1.01, -1.01, math.nan, math.inf])
def test_a_speed_that_is_too_high_or_none_is_refused(file: BenchFile, tmp_path: Path, share: float) -> None:
    with pytest.raises(LimitError, match=r"should be between 0 and 3\.41 °/s"):
        turned(file, tmp_path, 9, share * greatest_speed(file.configuration))


def test_a_stopped_bench_is_not_moved_by_hand(file: BenchFile, tmp_path: Path) -> None:
    latch_of(file, tmp_path).stopped("TEMPERATURE_HIGH", "too hot", datetime.now(UTC))
    with pytest.raises(LimitError, match="too hot"):
        turned(file, tmp_path, 9, 0.01)
