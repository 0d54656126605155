"""What acts in one place only is found there: a band of speed, a spell of time; and noise has no places."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bench.mismatch import bands
from bench.mismatch.assess import Assessment, assess
from bench.mismatch.bank import Bank, Noise
from bench.mismatch.columns import Entry
from bench.mismatch.given import Given
from bench.mismatch.rivals import QUANTITIES
from bench.simulation.frame import FloatArray, Frame, concatenate, recording_starts
from bench.simulation.model import Simulation
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE
from tests.bench.mismatch.synthetic import frames, torques

SPEEDS = (0.03, 0.06, 0.08, 0.1, 0.12, 0.17)


def found(extra_motor: Any = None, extra_load: Any = None) -> Assessment:
    data = torques(extra_motor, extra_load, SPEEDS)
    channel = MOTOR_TORQUE if extra_load is None else LOAD_TORQUE
    return assess(data, Given.of(Simulation.nominal()), (channel,))


def hump(frame: Frame) -> FloatArray:
    return 0.1 * frame.direction * np.exp(-0.5 * ((np.abs(frame.velocity) - 0.1) / 0.01) ** 2)


def test_a_hump_at_one_speed_is_unknown_and_at_that_speed() -> None:
    result = found(hump)
    (finding,) = result.findings
    assert (finding.effect, finding.channel) == ("unknown", MOTOR_TORQUE)
    low, high = finding.location.conditions["velocity"]
    assert 0.05 < low < 0.1 < high
    score = result.scores[MOTOR_TORQUE]
    assert score.after < 1.05 * score.floor < score.before


def test_a_zero_that_jumps_for_a_while_is_unknown_and_in_that_while() -> None:
    whole = concatenate([f for _, f in frames(SPEEDS)])
    begin, end = np.quantile(whole.time, [0.4, 0.62])
    result = found(None, lambda f: 4.0 * ((f.time >= begin) & (f.time < end)))
    own = [f for f in result.findings if f.channel == LOAD_TORQUE]
    assert [f.effect for f in own] == ["unknown"]
    assert own[0].location.time_window is not None
    assert "spell" in own[0].location.text
    told = {p["symbol"]: p["value"] for p in own[0].parameters}
    assert told["c_0"] == pytest.approx(4.0, abs=0.2)
    assert begin - 70.0 < told["begin"] < begin + 70.0
    assert end - 70.0 < told["end"] < end + 70.0
    score = result.scores[LOAD_TORQUE]
    assert score.after < 1.05 * score.floor < score.before


def test_friction_with_load_times_temperature_is_unknown_with_no_name_beside_it() -> None:
    def concealed(frame: Frame) -> FloatArray:
        return np.asarray(0.1 * frame.direction * np.abs(frame.torque) / 500.0 * (frame.temperature - 32.0) / 8.0)

    result = found(concealed)
    assert [f.effect for f in result.findings] == ["unknown"]
    assert "temperature together" in result.findings[0].location.text
    score = result.scores[MOTOR_TORQUE]
    assert score.after < 1.05 * score.floor < score.before


def test_at_rest_in_speed_no_acceleration_is_seen() -> None:
    frame, _ = plain(0)
    noisy = replace(frame, acceleration=np.random.default_rng(0).normal(size=frame.size))
    value = QUANTITIES["speeding_up"](noisy)
    steady = frame.steady > 0.5
    assert np.all(value[steady] == 0.0)
    assert np.all(value[~steady] != 0.0)


def plain(seed: int, extra: Any = None) -> tuple[Frame, Bank]:
    """A channel of noise with offsets between recordings, one constant column and free ones."""
    frame = concatenate([f for _, f in frames()])
    rng = np.random.default_rng(seed)
    offset = rng.normal(size=int(frame.recording.max()) + 1)[frame.recording]
    y = rng.normal(size=frame.size) + 0.3 * offset + (0.0 if extra is None else extra)
    columns = np.hstack([np.ones((frame.size, 1)), np.zeros((frame.size, bands.slots(LOAD_TORQUE)))])
    starts = recording_starts(frame)
    noise = Noise(np.ones(frame.size), np.zeros(frame.size), (0.0, 0.03, 0.1, 0.3, 1.0))
    bank = Bank(y, starts, np.arange(starts.size - 1), columns, np.zeros(columns.shape[1]), noise)
    return frame, bank


def test_noise_and_offsets_between_recordings_have_no_place() -> None:
    for seed in range(3):
        frame, bank = plain(seed)
        everywhere = np.ones(frame.size, dtype=bool)
        for entry in bands.fill(LOAD_TORQUE, frame, everywhere, bank, range(1, bank.size), [[0]]):
            assert bank.fit([0, *entry.index]).total - bank.fit([0]).total < 12.0


def test_the_gain_promised_is_that_of_the_fit() -> None:
    frame, bank = plain(1)
    column = bands.column(LOAD_TORQUE, "offset in a spell of time", (300.0, 900.0), frame)
    gram, product = bank.beside(column, [0])
    bank.replace([1], column)
    without, with_it = bank.fit([0], leave_out=False), bank.fit([0, 1], leave_out=False)
    assert without.offset_variance == with_it.offset_variance
    promised = 0.5 * float(product[0]) ** 2 / float(gram[0, 0])
    assert with_it.total - without.total == pytest.approx(promised, rel=1e-3)


def test_a_spell_is_found_from_its_first_recording_to_its_last() -> None:
    frame = concatenate([f for _, f in frames()])
    inside = (frame.recording >= 9) & (frame.recording < 15)
    _, bank = plain(2, 1.5 * inside)
    own = bands.places(LOAD_TORQUE, frame, np.ones(frame.size, dtype=bool), bank, [0])
    assert own[0].name == "offset in a spell of time"
    told = bands.column(LOAD_TORQUE, own[0].name, own[0].point, frame)[:, 0]
    assert np.array_equal(told > 0, inside)


def test_a_band_is_found_at_its_centre_in_its_width() -> None:
    frame, _ = plain(0)
    number = frame.recording.max() + 1
    speeds = np.random.default_rng(1).permutation(np.linspace(0.02, 0.17, number))[frame.recording]
    frame = replace(frame, velocity=speeds * np.sign(frame.velocity))
    _, bank = plain(4, 1.5 * np.exp(-0.5 * ((speeds - 0.1) / 0.012) ** 2))
    (first, *_) = bands.places(LOAD_TORQUE, frame, np.ones(frame.size, dtype=bool), bank, [0])
    assert first.name == "torque in a band of speed"
    assert first.point[0] == pytest.approx(0.1, abs=0.006)
    assert first.point[1] == pytest.approx(0.012, abs=0.005)
    assert "exp(-((speed - x_0)/w)**2/2)" in bands.equation(LOAD_TORQUE, first.name)


def test_places_fill_free_columns_and_no_more() -> None:
    frame, bank = plain(3)
    everywhere = np.ones(frame.size, dtype=bool)
    entries = bands.fill(LOAD_TORQUE, frame, everywhere, bank, [1, 2], [[0], [0]])
    assert [e.index for e in entries] == [(1,), (2,)]
    assert all(isinstance(e, Entry) and e.effect == "unknown" and not e.common for e in entries)
    assert bands.slots(TEMPERATURE) == 0
