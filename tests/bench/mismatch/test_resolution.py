"""What rounding leaves of a level: half a step where nothing moves, nothing where noise is larger than the step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.mismatch.recordings.resolution import unresolved
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.strength import trusted
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from tests.bench.mismatch.regression.synthetic import campaign, problem
from tests.bench.recording import builders

STEP, SIZE = 2.5, 2000


def recordings(folder: Path, noise: float, dtype: str = "int32") -> list[Recording]:
    """Sixteen levels of a torque in steps of 2.5 N·m, with ``noise`` in N·m before it is rounded."""
    rng = np.random.default_rng(2)
    made = []
    for number, level in enumerate(np.linspace(-900.0, 871.0, 16)):
        values = level + rng.normal(0.0, noise, SIZE) if noise else np.full(SIZE, level)
        codes = np.rint(values / STEP).astype(dtype)
        channels = {
            "time": (np.arange(SIZE) / 500.0, ChannelSpec.of("time", dtype="float64")),
            "load_motor_torque": (codes, ChannelSpec.of("load_motor_torque", dtype=dtype, scale=STEP)),
        }
        path = folder / f"r{number}.h5"
        write_recording(path, builders.header(path.stem, sample_rate=500.0), channels, [Segment("steady", 0, SIZE)], [])
        made.append(Recording.open(path))
    return made


@pytest.mark.parametrize(
    ("noise", "left"),
    [
        (0.0, STEP / np.sqrt(12.0)),
        # little noise is rounded itself: rather more is told than the 0.33 N·m that are left
        (0.2 * STEP, 0.55),
        (1.0 * STEP, 0.0),
    ],
)
def test_noise_smooths_what_rounding_leaves_of_a_level(tmp_path: Path, noise: float, left: float) -> None:
    assert unresolved(recordings(tmp_path, noise), "load_motor_torque") == pytest.approx(left, rel=0.3, abs=1e-6)


@pytest.mark.parametrize("noise", [0.05, 0.2])
def test_no_less_is_told_than_the_means_are_off(tmp_path: Path, noise: float) -> None:
    """The means of rounded values, against the levels."""
    made = recordings(tmp_path, noise * STEP)
    levels = np.linspace(-900.0, 871.0, 16)
    off = [r.si("load_motor_torque").mean() - level for r, level in zip(made, levels, strict=True)]
    left = float(np.sqrt(np.mean(np.square(off))))
    assert 0.7 * left < unresolved(made, "load_motor_torque") < 4.0 * left + 0.05 * STEP


def test_what_is_no_whole_number_is_not_rounded(tmp_path: Path) -> None:
    assert unresolved(recordings(tmp_path, 0.0, "float64"), "load_motor_torque") == 0.0
    assert unresolved([], "load_motor_torque") == 0.0


@pytest.mark.parametrize("most", [0.0, 30.0])
def test_no_effect_is_told_that_rounding_may_have_made(most: float) -> None:
    frame = campaign()
    own = problem(frame, np.random.default_rng(1).normal(0.0, 1.0, frame.size))
    plain = trusted(begun(own).model)
    assert trusted(begun(replace(own, unresolved=most)).model) == max(plain, most)
