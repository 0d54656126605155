"""Time stamps: dates and zones, what is doubled or backward, what is irregular, gaps, clocks of single channels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.importing import Imported
from bench.importing.stamps import evenness
from tests.bench.importing import builders

_CHANNEL = 'motor_torque = {variable = "M", unit = "N*m"}'


def _dates(start: str, count: int, seconds: float) -> list[str]:
    first = np.datetime64(start, "ms")
    return [str(first + np.timedelta64(round(1000 * seconds * i), "ms")) for i in range(count)]


def test_dates_give_time_and_start_and_a_zone_is_told_or_taken_for_utc(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", t=_dates("2026-07-01T12:00:00", 50, 0.25), M=range(50))
    done = builders.one(tmp_path, f'time = {{variable = "t", timezone = "Europe/Berlin"}}\n{_CHANNEL}')
    assert done.recording.started_at.isoformat() == "2026-07-01T10:00:00+00:00"
    assert done.recording.sample_rate == 4.0
    np.testing.assert_allclose(done.recording.si("time"), np.arange(50) / 4)
    (tmp_path / "out/a.h5").unlink()
    done = builders.one(tmp_path, f'time = {{variable = "t"}}\n{_CHANNEL}')
    assert done.recording.started_at.isoformat() == "2026-07-01T12:00:00+00:00"
    assert any("were taken for UTC" in note for note in done.notes)
    with pytest.raises(ConfigurationError, match=r"timezone: 'Bavaria' is no time zone, one such as"):
        builders.run(tmp_path, f'time = {{variable = "t", timezone = "Bavaria"}}\n{_CHANNEL}')


def test_the_end_of_summer_time_is_an_hour_that_comes_twice(tmp_path: Path) -> None:
    stamps = _dates("2026-10-25T02:59:00", 60, 1.0) + _dates("2026-10-25T02:00:00", 60, 1.0)
    builders.csv(tmp_path / "a.csv", t=stamps, M=range(120))
    sentence = builders.why(tmp_path, f'time = {{variable = "t"}}\n{_CHANNEL}')
    assert "time in line 62 is 3599 s before the stamp before (1 backward stamps in all)" in sentence
    assert "channels.time.timezone would be right" in sentence
    done = builders.one(tmp_path, f'time = {{variable = "t", timezone = "Europe/Berlin"}}\n{_CHANNEL}')
    np.testing.assert_allclose(np.diff(done.recording.si("time")), 1.0)


def test_seconds_since_1970_are_a_date(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", t=1.78e9 + np.arange(50) / 8, M=range(50))
    recording = builders.one(tmp_path, _CHANNEL).recording
    assert recording.started_at.timestamp() == 1.78e9
    np.testing.assert_allclose(recording.si("time"), np.arange(50) / 8, atol=1e-6)


@pytest.mark.parametrize(
    ("time", "sentence"),
    [
        (
            [0, 1, 2, 2, 3, 4, 5, 6],
            "time in line 5 is the same as the stamp before (1 doubled stamps in all); time should",
        ),
        ([0, 1, 2, 1.5, 3, 4, 5, 6], "time in line 5 is 0.5 s before the stamp before (1 backward stamps in all)"),
        ([0, 0, 0, 1, 1, 1, 2, 2], "the stamps are coarser than the samples, channels.time.rate"),
        ([0, 1, 2, 3, 4, 0, 1, 2], "the clock begins anew: start and stop of two recordings should cut there"),
        ([0, 1, 2, 3, 50, 51, 52, 53], "nothing stands between 3 and 50 s (line 6), 47 times the usual step of 1 s"),
    ],
)
def test_stamps_that_are_wrong_are_found_with_their_place(tmp_path: Path, time: list[float], sentence: str) -> None:
    builders.csv(tmp_path / "a.csv", t=time, M=range(len(time)))
    assert sentence in builders.why(tmp_path, _CHANNEL)


def test_irregular_stamps_are_resampled_or_refused_and_said(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.5, 1.5, 500)) / 100
    builders.csv(tmp_path / "a.csv", t=time, M=2.0 * time)
    assert "irregular = 'resample' brings" in builders.why(tmp_path, _CHANNEL, top='irregular = "refuse"')
    done = builders.one(tmp_path, _CHANNEL)
    step = np.diff(done.recording.si("time"))
    np.testing.assert_allclose(step, step[0])
    np.testing.assert_allclose(
        done.recording.si("motor_torque"), 2.0 * (time[0] + done.recording.si("time")), rtol=1e-9
    )
    assert any("were brought onto an even clock" in event.text for event in done.recording.events)


def test_small_jitter_and_lost_samples_are_left_as_they_are(tmp_path: Path) -> None:
    time = np.arange(500) / 100 + np.random.default_rng(3).uniform(0, 1e-4, 500)
    builders.csv(tmp_path / "a.csv", t=np.delete(time, [100, 101, 300]), M=range(497))
    done = builders.one(tmp_path, _CHANNEL)
    assert done.recording.size == 497
    assert not any("clock" in note for note in done.notes)
    assert any("by the time stamps 3 of 500 samples are missing" in note for note in done.notes)


@pytest.mark.parametrize("taken", [True, False], ids=["taken at the stamps", "taken evenly, stamped late"])
def test_stamps_that_shake_are_used_where_the_motion_is_smoother_over_them(tmp_path: Path, taken: bool) -> None:
    even = np.arange(2000) / 100
    time = even + np.random.default_rng(3).uniform(0.0, 2e-3, 2000)
    angle = 3.0 * np.sin(2.0 * (time if taken else even))
    builders.csv(tmp_path / "a.csv", t=np.round(time, 6), q=np.round(angle, 6))
    done = builders.one(tmp_path, 'motor_angle = {variable = "q", unit = "rad"}')
    resampled = any("were brought onto an even clock of 100 Hz" in note for note in done.notes)
    assert resampled is taken
    read = done.recording.si("motor_angle")
    clock = time[0] + np.arange(read.size) / 100 if taken else even
    assert np.abs(read - 3.0 * np.sin(2.0 * clock)).max() < 1e-3


def test_a_recording_is_cut_at_gaps_where_the_mapping_says_so(tmp_path: Path) -> None:
    time = np.concatenate([np.arange(100), np.arange(500, 650)]) / 100
    builders.csv(tmp_path / "a.csv", t=time, M=range(250))
    done = builders.run(tmp_path, _CHANNEL, top='gaps = "cut"')
    found = [item.recording for item in done if isinstance(item, Imported)]
    assert [recording.size for recording in found] == [100, 150]
    assert (found[1].started_at - found[0].started_at).total_seconds() == 5.0


def test_a_channel_may_have_a_clock_of_its_own(tmp_path: Path) -> None:
    time = np.arange(1000) / 100
    builders.csv(tmp_path / "a.csv", t=time, q=np.sin(time))
    slow = 0.5 + np.arange(20) / 2
    builders.csv(tmp_path / "slow.csv", ts=slow, T=20 + slow)
    channels = """
motor_angle = {variable = "q", unit = "rad"}
temperature = {variable = "T", unit = "degC", file = "slow.csv", time = "ts"}
"""
    done = builders.one(tmp_path, channels)
    assert done.recording.size == 950
    np.testing.assert_allclose(done.recording.si("temperature"), 20.5 + done.recording.si("time"), rtol=1e-9)
    assert any("temperature has a clock of its own (2 Hz)" in note for note in done.notes)
    assert any("50 rows outside of the time of temperature were left out" in note for note in done.notes)
    (tmp_path / "out/a.h5").unlink()
    assert "temperature 20" in builders.why(tmp_path, channels.replace(', time = "ts"', ""))


def test_a_rate_that_the_stamps_do_not_have_is_made_or_refused(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", t=np.arange(400) / 400.0, M=np.arange(400))
    mapping = _CHANNEL
    done = builders.one(tmp_path, mapping, top="sample_rate = 200.0")
    assert done.recording.sample_rate == 200.0
    np.testing.assert_allclose(np.diff(done.recording.si("time")), 1 / 200.0)
    np.testing.assert_allclose(done.recording.si("motor_torque"), np.arange(0, 400, 2))
    assert any("400 Hz" in note and "200 Hz asked for" in note for note in done.notes)
    (tmp_path / "out/a.h5").unlink()
    sentence = builders.why(tmp_path, mapping, top='sample_rate = 200.0\nirregular = "refuse"')
    assert "sample_rate is 200 Hz and the stamps are 400 Hz" in sentence


def test_a_clock_that_shakes_keeps_its_rate() -> None:
    steps = np.random.default_rng(0).uniform(0.001, 0.009, 4000)
    steps[::10] = 0.0041  # the median is no measure of the rate
    found = evenness(np.cumsum(steps))
    assert not found.even
    assert found.mean == pytest.approx(np.mean(steps), rel=1e-3)
    # two rates, one after the other: the finer one is kept
    mixed = evenness(np.cumsum(np.r_[np.full(3000, 0.001), np.full(1000, 0.005)]))
    assert mixed.mean == mixed.step == pytest.approx(0.001)


@pytest.mark.parametrize("more", [1, 2])
def test_a_state_logged_once_more_than_its_input_loses_its_last_sample(tmp_path: Path, more: int) -> None:
    time = np.arange(300 + more) / 100.0
    builders.csv(tmp_path / "a.csv", q=np.sin(time))
    builders.csv(tmp_path / "b.csv", M=np.cos(time[:300]))
    channels = """time = {rate = 100.0}
motor_angle = {variable = "q", unit = "rad"}
motor_torque = {file = "b.csv", variable = "M", unit = "N*m"}
"""
    if more > 1:
        assert "the variables differ in length" in builders.why(tmp_path, channels)
        return
    done = builders.one(tmp_path, channels)
    assert done.recording.size == 300
    assert any("the last sample of time, motor_angle was left out" in note for note in done.notes)
