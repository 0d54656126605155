"""What the motor's encoder misreads, told by the reaction that it does not have."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.given import Given
from bench.mismatch.orders.misread import TorqueCheck, torque_check
from bench.mismatch.orders.revolutions import Revolution, Seen
from bench.mismatch.recordings.vibration import HIGHEST_SHAFT_ORDER, ShaftSpectrum
from bench.mismatch.series_given import slope
from bench.simulation import Simulation
from bench.simulation.waves import Wave
from tests.bench.mismatch.orders.test_reaction import frame

RATIO, SHARE, NOISE = 185.0, 1.06, 1e-4
FOLLOWS = 3.0
"""N·m of the motor's inertia at the highest speed, for one radian of the motor's angle"""
RECORDINGS = 30
EVERY = frozenset(range(RECORDINGS))
DRAWN = np.random.default_rng(5)
LOAD = DRAWN.uniform(-800.0, 800.0, RECORDINGS)
SPEED = np.where(np.arange(RECORDINGS) % 2 == 0, 1.0, -1.0) * DRAWN.choice([0.05, 0.1, 0.17], RECORDINGS)
GEARBOX = (-4.0 + 3.0j) * 1e-6 * (1.0 + 0.1 * LOAD / 800.0)
"""b + j*a of order 185, which follows the load a little"""
ENCODER = (5.0 + 8.0j) * 1e-6


def bench(gearbox: complex | np.ndarray, encoder: complex) -> tuple[Seen, list[Revolution], list[ShaftSpectrum]]:
    """Revolutions that show both, and a motor torque that feels the gearbox alone; its loop follows the encoder."""
    rng = np.random.default_rng(6)
    gearbox = gearbox * np.ones(RECORDINGS)
    vectors = (gearbox + encoder)[:, None]
    sizes = np.ones(RECORDINGS)
    seen = Seen((RATIO,), vectors, np.zeros((RECORDINGS, 400), dtype=np.complex128), sizes, sizes, None)
    revolutions = [
        Revolution(k, slice(0, 1), float(LOAD[k]), float(SPEED[k]), 30.0, 60.0 * k, float(np.sign(SPEED[k])), 1.1, 40.0)
        for k in range(RECORDINGS)
    ]
    shaft = []
    for k in range(RECORDINGS):
        amplitude = NOISE * (rng.normal(size=HIGHEST_SHAFT_ORDER + 1) + 1j * rng.normal(size=HIGHEST_SHAFT_ORDER + 1))
        # the torque that d/dtheta of a*cos + b*sin takes of the load, as a + j*b
        cosine, sine = gearbox[k].imag, gearbox[k].real
        amplitude[1] += SHARE * LOAD[k] / RATIO * RATIO * (sine - 1j * cosine)
        # the shaft is turned against the error, so that the encoder says an even speed
        amplitude[1] -= FOLLOWS * 1j * np.conj(encoder) * RATIO * (SPEED[k] / 0.17) ** 2
        shaft.append(ShaftSpectrum(k, amplitude, NOISE, float(LOAD[k] / RATIO), float(SPEED[k]), 30.0))
    return seen, revolutions, shaft


def ask(gearbox: complex | np.ndarray, encoder: complex, recordings: frozenset[int] = EVERY) -> TorqueCheck:
    seen, revolutions, shaft = bench(gearbox, encoder)
    return torque_check(seen, revolutions, recordings, shaft, RATIO, (SHARE, 0.01), [RATIO])


def test_its_part_is_found_beside_the_gearboxs_own_order() -> None:
    (part,) = ask(GEARBOX, ENCODER).found
    assert abs(part.vector - ENCODER) < 4.0 * part.std
    assert 0.0 < part.std < 0.05 * abs(ENCODER)
    assert part.beside
    assert part.p_value < 1e-6
    assert part.wave == Wave(RATIO, "1", part.vector.imag, part.vector.real, part.std, part.std)


def test_an_order_of_its_own_has_nothing_beside_it() -> None:
    (part,) = ask(0.0, ENCODER).found
    assert not part.beside
    assert ask(0.0, ENCODER).beside(RATIO) == 0.0


def test_an_order_of_the_gearbox_is_not_the_encoders() -> None:
    told = ask(GEARBOX, 0.0)
    assert told.orders == (RATIO,)
    assert not told.found


@pytest.mark.parametrize("answered", [0.9, 0.45, 0.2])
def test_a_loop_that_answers_this_order_less_than_others_is_no_encoder(answered: float) -> None:
    """The part of the order that has no reaction has its phase, and is not the whole of it."""
    seen, revolutions, _ = bench(GEARBOX, 0.0)
    shaft = bench(answered * GEARBOX, 0.0)[2]
    assert not torque_check(seen, revolutions, EVERY, shaft, RATIO, (SHARE, 0.01), [RATIO]).found


def test_an_error_in_the_phase_of_the_order_is_told_by_how_the_drive_follows_it() -> None:
    """A part of the order with its phase: as a loop that answers less, but that turns no shaft against it."""
    (part,) = ask(GEARBOX, 1.5 * (-4.0 + 3.0j) * 1e-6).found
    assert part.followed
    assert abs(part.vector - 1.5 * (-4.0 + 3.0j) * 1e-6) < 4.0 * part.std


def test_too_few_recordings_are_not_asked() -> None:
    assert ask(GEARBOX, ENCODER, frozenset(range(8))) == TorqueCheck()


def test_a_simulation_file_keeps_the_gearboxs_part_of_an_order() -> None:
    """The encoder's wave is in the transmission error and in no reaction; a wave of the same order beside it is."""
    own, encoder = Wave(46.0, "1", 2e-6, 1e-6), Wave(46.0, "1", 5e-6, 8e-6)
    document = Simulation.nominal().to_json()
    channels = ["transmission_error"]
    document["terms"] += [
        {"effect": "te.harmonic", "enabled": True, "channels": channels, "waves": [own.to_json()]},
        {"effect": "sensor.motor_encoder", "enabled": True, "channels": channels, "waves": [encoder.to_json()]},
    ]
    both = Given.of(Simulation.from_json(document))
    document["terms"].pop()
    alone = Given.of(Simulation.from_json(document))
    assert both.acting_waves == alone.acting_waves == (own,)
    assert both.waves["transmission_error"] == (own, encoder)
    assert np.array_equal(slope(both, frame()), slope(alone, frame()))
