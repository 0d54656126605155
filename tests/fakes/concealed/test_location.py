from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fakes.concealed import cases, open_folder
from fakes.concealed.effects.formula import FORMS
from fakes.concealed.location import smallest_range
from tests.fakes.concealed.test_effects import SMALL


def test_the_smallest_range_holds_nine_tenths_of_the_energy() -> None:
    rng = np.random.default_rng(1)
    x = rng.uniform(-1000.0, 1000.0, 20_000)
    energy = np.where(np.abs(x - 300.0) < 50.0, 1.0, 1e-3)
    low, high = smallest_range(x, energy)
    assert 250.0 <= low < high <= 350.0
    inside = (x >= low) & (x <= high)
    assert energy[inside].sum() >= 0.9 * energy.sum()
    assert high - low < 99.0


def test_one_strong_sample_is_a_range_of_its_own() -> None:
    assert smallest_range(np.array([3.0, 1.0, 2.0]), np.array([0.0, 100.0, 1.0])) == (1.0, 1.0)


@pytest.fixture(scope="module")
def slow():
    """Stribeck friction that is over within a few rad/s of the motor."""
    spec = next(c for c in cases("clear", 2) if c.forms[0].effect == "friction.stribeck")
    folder = open_folder(replace(spec, design=SMALL, shape=(("w_s", 2.0),)))
    return folder, {r.name: r for r in folder.recordings()}


def test_a_place_is_measured_in_ranges_directions_and_recordings(slow) -> None:
    folder, recordings = slow
    place = folder.effects[0].location
    assert place.measured.keys() == place.span.keys() == {"velocity", "load_torque", "temperature"}
    for name, (low, high) in place.measured.items():
        assert place.span[name][0] <= low < high <= place.span[name][1]
    assert place.measured["velocity"][0] < 0.02
    assert place.measured_direction == "both"
    assert set(place.recordings) <= set(recordings)
    strongest = max(place.recordings, key=lambda r: place.recordings[r])
    assert recordings[strongest].kind in ("velocity_ramp", "reversal")


def test_noise_is_told_of_each_recording(slow) -> None:
    folder, recordings = slow
    truth = folder.truth()
    assert set(truth.noise_by_recording) == set(recordings)
    steady = [n["motor_torque"] for n in truth.noise_by_recording.values() if "motor_torque" in n]
    assert min(steady) < truth.noise_rms["motor_torque"] < max(steady)
    assert all("temperature" in n for n in truth.noise_by_recording.values())


def test_of_several_effects_each_span_is_what_the_recordings_cover() -> None:
    warming = next(f for f in FORMS if f.effect == "friction.viscous_quadratic")
    other = next(f for f in FORMS if f.effect == "friction.position_dependent")
    spec = next(c for c in cases("clear", 2) if c.forms[0].effect == "friction.stribeck")
    spec = replace(spec, design=SMALL, forms=(warming, other), strengths=(6.0, 1.0), shape=())
    folder = open_folder(spec)
    read = [r.channels["temperature"] for r in folder.recordings()]
    highest = max(float((c.raw * c.scale).max()) for c in read)
    alone = open_folder(replace(spec, forms=(other,), strengths=(1.0,))).effects[0].location.span["temperature"][1]
    spans = [e.location.span["temperature"][1] for e in folder.effects]
    assert spans == pytest.approx([highest, highest], abs=0.3)
    assert highest > alone + 1.0
