"""Whose the orders of the motor's shaft are: by whether its torque follows the motion that it is said to have."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.importing import Imported
from bench.mismatch.discovery import AMBIGUOUS, NAMED, Discovery, RefittedAlternative
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.loading import load
from bench.mismatch.whose_orders import gained, told, waves_of
from bench.simulation.waves import Wave
from tests.bench.importing import builders
from tests.bench.mismatch.report import made

RATIO, INERTIA = 20.0, 0.02
WAVE = Wave(RATIO, "1", 8e-4, -3e-4)
"""of the transmission error, once a revolution of the motor"""


def joint(
    folder: Path, misread: bool, inertia: float = INERTIA, viscous: float = 0.002, cogging: float = 0.0
) -> Dataset:
    """Seven recordings of a joint to and fro: the encoder of its motor misreads a wave, or the gearbox makes it; with
    ``cogging`` of the motor, which stands at the same order.
    """
    rng = np.random.default_rng(2)
    time = np.arange(2000) / 200.0
    for number in range(7):
        angle = 0.9 * np.sin(1.1 * time + number) + 0.3 * np.sin(2.3 * time)
        speed = 0.99 * np.cos(1.1 * time + number) + 0.69 * np.cos(2.3 * time)
        change = -1.089 * np.sin(1.1 * time + number) - 1.587 * np.sin(2.3 * time)
        wave = WAVE.cosine * np.cos(RATIO * angle) + WAVE.sine * np.sin(RATIO * angle)
        # the transmission error is the output less the motor's angle over the ratio
        motor, output = (angle - wave, angle) if misread else (angle, angle + wave)
        torque = 0.05 * np.sign(speed) + viscous * RATIO * speed + inertia * RATIO * change
        torque += cogging * np.cos(RATIO * angle + np.arctan2(-WAVE.sine, WAVE.cosine))
        noise = rng.normal(0.0, 0.01, (3, time.size)) * np.array([[1e-4], [1e-3], [1.0]])
        builders.csv(
            folder / f"a{number}.csv",
            t=time,
            q=RATIO * (motor + noise[0]),
            p=output + noise[1],
            M=torque + noise[2],
        )
    channels = """
motor_angle = {variable = "q", unit = "rad"}
load_angle = {variable = "p", unit = "rad"}
motor_torque = {variable = "M", unit = "N*m"}
"""
    done = builders.run(folder, channels, file="*.csv", ratio=str(RATIO))
    assert all(isinstance(one, Imported) for one in done)
    return load(folder / "out")


def of_orders(effect: str = "te.harmonic", alternative: str = "sensor.motor_encoder", **more: Any) -> Discovery:
    """The wave as a discovery that may be either's."""
    other = RefittedAlternative(alternative, "", np.inf, np.inf, np.nan, True)
    row = {"effect": effect, "channels": ["transmission_error"], "waves": [WAVE.to_json()]}
    found = made.discovery("transmission_error", effect, np.zeros(1), ("angle",), status=AMBIGUOUS, orders=(RATIO,))
    return replace(found, alternatives=(other,), simulation_rows=(row,), **more)


@pytest.mark.parametrize(("misread", "effect"), [(True, "sensor.motor_encoder"), (False, "te.harmonic")])
def test_the_torque_follows_the_motion_that_was_not_misread(tmp_path: Path, misread: bool, effect: str) -> None:
    data = joint(tmp_path, misread)
    gain = gained([WAVE], data)
    assert gain is not None
    assert gain.better * (1.0 if misread else -1.0) > 3.0 * gain.error
    assert gain.recordings == len([m for m in data.members if not m.held_out])
    found = told(of_orders(), data)
    assert (found.effect, found.status, found.alternatives) == (effect, NAMED, ())
    assert {row["effect"] for row in found.simulation_rows} == {effect}
    assert waves_of(found) == waves_of(of_orders())
    other = told(of_orders("sensor.motor_encoder", "te.harmonic"), data)
    assert other.effect == effect


@pytest.mark.parametrize("cogging", [-0.05, 0.05])
@pytest.mark.parametrize(("misread", "effect"), [(True, "sensor.motor_encoder"), (False, "te.harmonic")])
def test_cogging_at_the_same_order_decides_nothing(tmp_path: Path, misread: bool, effect: str, cogging: float) -> None:
    """It is as large as the dry friction, in phase or against what the inertia would ask for."""
    assert told(of_orders(), joint(tmp_path, misread, cogging=cogging)).effect == effect


def test_a_rotor_whose_torque_does_not_follow_its_motion_says_nothing(tmp_path: Path) -> None:
    data = joint(tmp_path, misread=True, inertia=0.0, viscous=0.0)
    found = of_orders()
    assert told(found, data) is found


def test_what_the_loads_reaction_has_decided_stays(tmp_path: Path) -> None:
    data = joint(tmp_path, misread=True)
    found = of_orders()
    assert told(found, data, (RATIO,)) is found
    # an order that has no one vector has no one motion either; and a name that is no matter of encoders stays
    assert told(replace(found, orders=(RATIO, 3.0)), data).effect == "te.harmonic"
    sideband = of_orders("te.sideband", "te.harmonic")
    assert told(sideband, data) is sideband


def test_without_recordings_that_may_be_fitted_nothing_is_told(tmp_path: Path) -> None:
    data = joint(tmp_path, misread=True)
    members = [replace(m, held_out=True, fold=-1) for m in data.members]
    assert gained([WAVE], replace(data, members=members)) is None
