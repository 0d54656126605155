"""Tones: found at their frequency, not in noise, and no order of the gearbox is one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.discovery import TONE, Look, Structure
from bench.mismatch.recordings.vibration import Density
from bench.mismatch.unnamed.structure import look_for_tone, matters
from bench.mismatch.unnamed.tones import FELT_DOUBT, MOST_AMPLIFIED, Tone, _drawn, _stands_out, tone
from tests.bench.mismatch.report import made
from tests.bench.mismatch.spectra import densities

SEEDS = range(6)


def heard(seed: int, orders: tuple[float, ...] = (), **what: tuple[float, float]) -> Tone:
    # surrogates of one seed for all: they depend on the recordings' kind alone and are drawn once
    found = tone(densities(seed, **what), 0, orders)  # type: ignore[arg-type]
    assert found is not None
    return found


def test_a_tone_is_found_at_its_frequency() -> None:
    found = heard(1, tone=(17.3, 0.4))
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert abs(found.frequency - 17.3) <= 3.0 * found.frequency_std
    assert found.amplitude == pytest.approx(0.4, rel=0.15)


@pytest.mark.parametrize("frequency", [17.3, 17.325, 17.35, 17.42])
def test_a_tone_between_two_lines_of_the_spectrum_has_its_frequency_and_amplitude(frequency: float) -> None:
    """At the line itself it looks up to 15 % smaller."""
    found = heard(1, white=0.04, tone=(frequency, 0.4))
    assert found.frequency == pytest.approx(frequency, abs=max(3.0 * found.frequency_std, 2e-4))
    assert found.frequency_std < 0.01
    assert found.amplitude == pytest.approx(0.4, abs=max(3.0 * found.amplitude_std, 2e-3))
    assert found.amplitude_std < 0.02


def test_frequency_and_amplitude_are_as_uncertain_as_they_scatter() -> None:
    found = [heard(seed, tone=(17.34, 0.3)) for seed in range(24)]
    frequency = [(f.frequency - 17.34) / f.frequency_std for f in found]
    amplitude = [(f.amplitude - 0.3) / f.amplitude_std for f in found]
    assert 0.7 < np.sqrt(np.mean(np.square(frequency))) < 1.4
    assert 0.7 < np.sqrt(np.mean(np.square(amplitude))) < 1.4


@pytest.mark.parametrize("seed", SEEDS)
def test_noise_has_no_tone(seed: int) -> None:
    assert heard(seed).p_value > criteria.ERROR_RATE_OF_A_CHANNEL


def test_an_order_moves_with_the_speed_and_is_no_tone() -> None:
    assert heard(1, order=(1000.0, 3.0)).p_value > criteria.ERROR_RATE_OF_A_CHANNEL


def test_recordings_that_are_not_steady_tell_how_large_it_is_there() -> None:
    own = densities(1, tone=(17.3, 0.4))
    loud = replace(densities(2, tone=(17.3, 1.2))[0], recording=100)
    still = replace(densities(3)[0], recording=101)
    found = tone(own, 1, (), [loud, still])
    assert found is not None
    plain = tone(own, 1)
    assert plain is not None
    assert (found.frequency, found.amplitude, found.p_value) == (plain.frequency, plain.amplitude, plain.p_value)
    held = dict(zip(found.recordings, found.squares, strict=True))
    assert found.recordings[0] == 100
    assert held[100] == pytest.approx(0.5 * 1.2**2, rel=0.1)
    assert held[101] < 0.1 * 0.5 * 0.4**2


def test_one_speed_cannot_tell_tones_from_orders() -> None:
    assert tone([d for d in densities(1) if d.rotation_rate == 0.005], 1) is None


def test_where_orders_cover_most_speeds_noise_looks_more_like_a_tone() -> None:
    """The median of three speeds scatters more than that of nine."""
    groups = np.repeat(np.arange(9), 2)
    freedom = np.full(18, 12.0)
    few = np.zeros((18, 50), dtype=bool)
    few[:6] = True
    all_speeds, three = (_drawn(freedom, groups, 200, 1, looked) for looked in (None, few))
    assert np.median(three) > 1.1 * np.median(all_speeds)
    assert np.isfinite(three).all()


@pytest.mark.parametrize(("amplitude", "there"), [(0.0, False), (0.05, True)])
def test_a_tone_stands_out_of_what_a_strong_order_leaks(amplitude: float, there: bool) -> None:
    """The order's line is far above the noise at every speed, and so are its side lobes."""
    found = heard(2, orders=(100.0,), white=1e-3, order=(100.0, 0.3), tone=(1.6, amplitude))  # type: ignore[arg-type]
    assert (found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL) is there
    if there:
        assert abs(found.frequency - 1.6) <= 0.1


@pytest.mark.parametrize("orders", [(), (100.0, 300.0)])
def test_noise_that_rises_towards_low_frequencies_is_no_tone(orders: tuple[float, ...]) -> None:
    assert heard(3, orders=orders, white=0.2, slow=1.0, memory=0.8).p_value > criteria.ERROR_RATE_OF_A_CHANNEL  # type: ignore[arg-type]


def test_a_tone_that_orders_explain_is_none() -> None:
    """The load's inertia makes its torque feel orders of the transmission error."""
    own, felt = (made.outcome(made.campaign(), "load_torque", [], 1.0) for _ in range(2))
    own.structure = felt.structure = Structure.of({"mean": Look("nothing", 0.5, 0.5)})
    seen = densities(1, tone=(17.3, 0.4))
    look_for_tone(own, seen)
    assert [d.effect for d in own.discoveries] == ["unknown"]
    assert own.structure is not None
    assert own.structure.p_value == pytest.approx(2.0 * own.structure.looks[TONE].p_value)
    look_for_tone(felt, seen, orders=[17.3 / d.rotation_rate for d in seen])
    assert felt.discoveries == []
    assert felt.structure is not None
    assert felt.structure.p_value is not None
    assert felt.structure.p_value > criteria.ERROR_RATE_OF_A_CHANNEL


@pytest.mark.parametrize(("amplitude", "std", "told"), [(1.0, 0.1, True), (1.0, 0.9, False), (0.2, 0.01, False)])
def test_a_tone_counts_where_it_is_strong_and_recordings_share_it(amplitude: float, std: float, told: bool) -> None:
    """Power that one speed has and the others have not is no tone of the channel."""
    found = Tone(1.4, 0.03, amplitude, std, 1e-4, (0, 1))
    assert matters(found, 1.0) is told


DENSE = tuple(float(k) for k in range(1, 12000, 4))
"""orders of which at every speed one lies at every frequency"""


def test_a_tone_is_found_among_orders_that_a_torque_cannot_feel_as_much() -> None:
    own = densities(1, tone=(17.3, 0.4))
    by_inertia = (2.0 * np.pi * 17.3) ** 2
    covered = tone(own, 1, DENSE)
    assert covered is None or covered.p_value > criteria.ERROR_RATE_OF_A_CHANNEL
    for felt, heard_ in ((1e-4 / by_inertia, True), (0.5 / by_inertia, False)):
        found = tone(own, 1, DENSE, felt=np.full(len(DENSE), felt).tolist())
        assert (found is not None and found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL) is heard_
        if heard_:
            assert found is not None
            assert abs(found.frequency - 17.3) < 0.05


@pytest.mark.parametrize("seed", range(10))
def test_among_orders_near_the_noise_noise_has_no_tone(seed: int) -> None:
    """Lines at which noise happens to stand above what a mode may make of an order are looked at."""
    own = densities(seed)
    # an amplitude whose line a mode lifts just above the noise of its bins
    noise = float(np.median(own[0].power)) * 5.0 * own[0].step
    felt = np.sqrt(2.0 * noise) / (FELT_DOUBT * MOST_AMPLIFIED) / (2.0 * np.pi * 20.0) ** 2
    found = tone(own, seed, DENSE, felt=np.full(len(DENSE), felt).tolist())
    assert found is None or found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL


def test_where_orders_cover_a_part_a_chance_in_noise_is_as_rare_as_it_says() -> None:
    """The noise about a frequency is told by fewer frequencies there, and less surely."""
    rng = np.random.default_rng(5)
    chances = []
    for seed in range(60):
        orders = np.sort(rng.choice(np.arange(1.0, 4000.0), 600, replace=False)).tolist()
        found = tone(densities(seed, recordings=8), seed, orders)
        chances.append(1.0 if found is None else found.p_value)
    assert sum(p < 0.05 for p in chances) <= 8
    assert sum(p < criteria.ERROR_RATE_OF_A_CHANNEL for p in chances) <= 1


@pytest.mark.parametrize("seed", range(4))
def test_orders_that_a_mode_makes_large_are_no_tone(seed: int) -> None:
    """A mode stands at one frequency at every speed, and of its many orders one is there at each."""
    rng = np.random.default_rng(seed)
    step, natural, damping, averaged = 0.1, 25.0, 0.01, 8.0
    orders = np.arange(1.0, 400.0)
    felt = 2e-3 / (2.0 * np.pi * natural) ** 2
    seen = []
    for number, rotation in enumerate(np.geomspace(0.05, 0.6, 6)):
        hertz = orders * rotation
        large = (
            felt * (2.0 * np.pi * hertz) ** 2 / np.abs(1.0 - (hertz / natural) ** 2 + 2j * damping * hertz / natural)
        )
        power = rng.chisquare(2.0 * averaged, 600) / (2.0 * averaged) * 1e-6
        for shift, share in ((-1, 1.0 / 6.0), (0, 2.0 / 3.0), (1, 1.0 / 6.0)):
            at = np.round(hertz / step).astype(int) + shift
            inside = (at >= 0) & (at < power.size)
            np.add.at(power, at[inside], share * 0.5 * large[inside] ** 2 / step)
        seen.append(Density(number, power, step, averaged, 2.0 * step * 599, float(rotation)))
    found = tone(seen, seed, orders.tolist(), felt=[felt] * orders.size)
    assert found is None or found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL


def test_what_is_no_line_among_what_is_about_it_is_no_tone() -> None:
    """What a pulse leaves at low frequencies is loud beside the few frequencies that known orders leave."""
    seen = []
    rng = np.random.default_rng(2)
    for number, rotation in enumerate(np.geomspace(0.05, 0.2, 12)):
        power = rng.chisquare(16.0, 600) / 16.0
        power[12:22] *= 20.0
        # orders stand to both sides of what is loud, as large as it is
        power[2:12] *= 40.0
        power[22:33] *= 40.0
        seen.append(Density(number, power, 0.1, 8.0, 120.0, float(rotation)))
    assert not _stands_out(np.array([d.power for d in seen]), np.ones(len(seen), dtype=bool), 17)
    found = tone([replace(d, power=np.where(np.arange(600) == 200, 30.0, d.power)) for d in seen], 1)
    assert found is not None
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert found.frequency == pytest.approx(20.0, abs=0.1)


@pytest.mark.parametrize(("with_it", "everywhere"), [(0.6, False), (1.0, True)])
def test_a_tone_of_some_recordings_is_as_large_as_it_is_there(with_it: float, everywhere: bool) -> None:
    """As of a load that is beyond a limit, at whatever speed: the others have nothing of it."""
    loud, still = densities(1, tone=(17.3, 0.4)), densities(2)
    number = round(with_it * len(loud))
    mixed = [loud[k] if (7 * k) % len(loud) < number else still[k] for k in range(len(loud))]
    found = tone(mixed, 0)
    assert found is not None
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert found.everywhere is everywhere
    assert found.amplitude == pytest.approx(0.4, rel=0.15)


def test_a_tone_that_is_smaller_in_some_recordings_is_still_everywhere() -> None:
    loud, small = densities(1, tone=(17.3, 0.4)), densities(2, tone=(17.3, 0.2))
    found = tone([loud[k] if k % 2 else small[k] for k in range(len(loud))], 0)
    assert found is not None
    assert found.everywhere
