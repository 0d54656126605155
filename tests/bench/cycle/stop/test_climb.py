"""The stop ladder on a rig that is only a clock and two speeds."""

from collections.abc import Callable
from dataclasses import fields, replace
from datetime import UTC, datetime
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.configuration import load_bench
from bench.cycle.decode import Decoded
from bench.cycle.sink import NoSink
from bench.cycle.stop import climb
from bench.cycle.stop.climb import Stop
from bench.protocols import Segment
from bench.safety import Cause, Inputs, StopRecord

BENCH = load_bench("rh380n").configuration
CYCLE_S = BENCH.bus.cycle_time
Speeds = Callable[[float], tuple[float, float]]


class Rig:
    """Each step of the ladder takes ``step_s`` of the clock; ``good`` says until when frames come back."""

    def __init__(self, speeds: Speeds, step_s: float = 0.02, cycles: int = 40, good: float = 1e9) -> None:
        self._speeds, self._step_s, self._cycles, self._good = speeds, step_s, cycles, good
        self.set_values = (0.5, 300.0)
        self.time, self.cycle, self.frames, self.off, self.silent = 100.0, 1000, 0, False, False
        self.now = datetime.now(UTC)
        self.powered, self.is_real_time = True, True

    @property
    def sent_values(self) -> tuple[float, float]:
        return self.set_values

    def clock(self) -> float:
        return self.time

    def missing_ahead(self, n: int) -> int:
        return round(self._step_s / CYCLE_S)

    def drop_ahead(self) -> None:
        pass

    def go_silent(self) -> None:
        self.silent = True

    def drives_off(self) -> bool:
        return self.off

    @property
    def drive_states(self) -> dict[str, str]:
        return {"input_drive": "OFF" if self.off else "ON"}

    def stop_cycles(self, n: int, least: int, velocity: float, torque: float, goal: str | None, sink: Any) -> Decoded:
        assert not self.silent
        self.set_values, self.off = (velocity, torque), self.off or goal == "DISABLED"
        motor, load = self._speeds(self.time - 100.0)
        count = self._cycles
        good = np.full(count, self.time - 100.0 < self._good)
        zeros = {field.name: np.zeros(count) for field in fields(Inputs)}
        inputs = replace(Inputs(**zeros), motor_velocity=np.full(count, motor), load_velocity=np.full(count, load))
        cycles = np.arange(self.cycle, self.cycle + count)
        self.time, self.cycle, self.frames = self.time + self._step_s, self.cycle + count, self.frames + count
        return Decoded({"cycle": cycles}, replace(inputs, good=good), None)


class Texts(NoSink):
    def __init__(self) -> None:
        self.texts: list[str] = []

    def event(self, level: str, text: str) -> None:
        self.texts.append(text)

    def segment(self, segment: Segment | None) -> None:
        assert segment is Segment.RAMP_DOWN


def stopped(rig: Rig, cause: Cause = Cause.OPERATOR) -> tuple[StopRecord, list[str]]:
    sink = Texts()
    return Stop(rig, BENCH, CYCLE_S, 4000).run(cause, sink), sink.texts


@pytest.mark.parametrize("cycles", [1, 10, 40, 160])
@pytest.mark.parametrize("step_s", [0.02, 0.08])
def test_deadlines_are_those_of_the_clock_however_many_cycles_come(cycles: int, step_s: float) -> None:
    rig = Rig(lambda _: (80.0, 0.4), step_s, cycles)
    record, texts = stopped(rig)
    lasted = {rung.rung: rung.lasted_s for rung in record.rungs}
    assert lasted["controlled ramp"] == pytest.approx(BENCH.stopping.controlled_ramp, abs=2 * step_s)
    assert lasted["quick stop"] == pytest.approx(BENCH.stopping.quick_stop, abs=2 * step_s)
    assert lasted["disable voltage"] == pytest.approx(BENCH.stopping.disable_voltage, abs=2 * step_s)
    assert lasted["stop sending"] == 0.0
    assert rig.silent
    assert record.lasted_s == pytest.approx(15.0, abs=6 * step_s)
    assert "nobody sees" in texts[-1]


@pytest.mark.parametrize("step_s", [0.02, 0.08])
def test_the_ramp_takes_its_time_by_the_clock(step_s: float) -> None:
    rig = Rig(lambda _: (0.0, 0.0), step_s)
    record, _ = stopped(rig)
    motion = BENCH.motion
    nominal = 300.0 / motion.torque_rate + 0.5 * BENCH.gearbox.ratio / motion.motor_acceleration
    assert record.rungs[0].lasted_s == pytest.approx(nominal, abs=3 * step_s)


def coasting(motor_s: float, load_s: float) -> Speeds:
    return lambda now: (80.0 if now < motor_s else 0.1, 0.4 if now < load_s else 1e-4)


@pytest.mark.parametrize(("motor_s", "load_s"), [(0.2, 0.5), (0.5, 0.2), (0.3, 0.3)])
def test_rest_is_that_of_the_later_shaft(motor_s: float, load_s: float) -> None:
    record, texts = stopped(Rig(coasting(motor_s, load_s)), Cause.MOTOR_SPEED)
    assert record.to_rest_s == pytest.approx(max(motor_s, load_s), abs=0.05)
    assert record.shafts_at_rest == {"input": True, "load": True}
    assert texts[-1] == "bench at rest"


def test_a_load_shaft_that_is_not_seen_at_rest_is_not_said_to_be() -> None:
    record, texts = stopped(Rig(coasting(0.2, 1e9)), Cause.MOTOR_SPEED)
    assert record.to_rest_s is None
    assert record.shafts_at_rest == {"input": True, "load": False}
    assert texts[-1] == "the stop has ended; not seen at rest: load shaft"
    assert record.lasted_s == pytest.approx(1.0, abs=0.1), "no voltage, input at rest: it is looked for a second"


def test_the_moment_of_rest_is_stamped_by_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig(coasting(0.2, 0.4))
    # the clock of the computer goes three times as fast as the bench's
    monkeypatch.setattr(climb, "time", SimpleNamespace(time_ns=lambda: round(3e9 * (rig.time - 100.0))))
    record, _ = stopped(rig, Cause.MOTOR_SPEED)
    assert record.to_rest_s == pytest.approx(0.42, abs=0.03)
    assert record.rest_seen_at_ns == pytest.approx(3e9 * 0.46, abs=3e9 * 0.05)
    assert record.rungs[0].at_ns == 0


def test_a_bench_faster_than_the_clock_stamps_nothing_by_the_clock() -> None:
    rig = Rig(coasting(0.2, 0.5))
    rig.is_real_time = False
    record, _ = stopped(rig, Cause.MOTOR_SPEED)
    assert record.to_rest_s is not None
    assert record.rest_seen_at_ns is None
    assert {rung.at_ns for rung in record.rungs} == {None}


def test_one_slow_moment_is_no_rest() -> None:
    record, _ = stopped(Rig(lambda now: (80.0 if not 0.1 < now < 0.13 and now < 0.4 else 0.1, 0.0)), Cause.MOTOR_SPEED)
    assert record.to_rest_s == pytest.approx(0.42, abs=0.03)


def test_a_bus_that_dies_ends_the_stop_at_once_and_nothing_is_said_of_the_shafts() -> None:
    rig = Rig(coasting(9.0, 9.0), good=0.1)
    record, texts = stopped(rig, Cause.MOTOR_SPEED)
    assert rig.silent
    assert record.lasted_s == pytest.approx(0.16, abs=0.05)
    assert (record.to_rest_s, record.shafts_at_rest) == (None, {"input": None, "load": None})
    assert set(record.drives.values()) == {"not seen"}
    assert "not seen at rest" in texts[-2]


def test_a_stop_of_which_nothing_was_seen_has_no_figures() -> None:
    record, _ = stopped(Rig(coasting(9.0, 9.0), good=-1.0), Cause.BUS_ENDED)
    assert (record.cycle, record.to_rest_s, record.motor_travel_rad) == (None, None, None)
    assert "unseen" in record.summary
