"""Truth about a plant's recordings, from what its ledger says and what a twin's noise is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fakes.plant.hidden.ledger import EVERY, row_dtype
from fakes.sealed import concealed_in, noise_of, truth_of

COUNT = 1500
"""samples of a recording, 100 Hz"""


def samples(seed: int) -> list[dict[str, Any]]:
    """Steady recordings at four speeds and three loads, both ways; noise of a known size in every channel."""
    rng = np.random.default_rng(seed)
    out: list[dict[str, Any]] = []
    for speed in (0.03, 0.06, 0.11, 0.17):
        for load in (-500.0, 0.0, 500.0):
            for side in (1.0, -1.0):
                rate = np.full(COUNT, side * speed)
                theta = np.cumsum(rate) * 0.01
                out.append(
                    {
                        "id": f"{len(out):04d}",
                        "cycle": (np.arange(COUNT) + len(out) * COUNT) * EVERY,
                        "steady": np.ones(COUNT, dtype=bool),
                        "step_s": 0.01,
                        "ratio": 185.0,
                        "theta": theta,
                        "rate": rate,
                        "side": np.full(COUNT, side),
                        "torque": np.full(COUNT, load) + rng.normal(0.0, 1.0, COUNT),
                        "load_torque": load + rng.normal(0.0, 0.9, COUNT),
                        "load_motor_torque": np.full(COUNT, load),
                        "load_angle": theta + rng.normal(0.0, 1.2e-6, COUNT),
                        "motor_torque": 0.5 * side + 1.11 * rate + load / 185.0 + rng.normal(0.0, 0.03, COUNT),
                        "temperature": 22.0 + 0.01 * len(out) + rng.normal(0.0, 0.02, COUNT),
                    }
                )
    return out


def ledger(path: Path, rows: list[dict[str, Any]], channel: int, values: Any) -> str:
    """A ledger of one kind that adds ``values(recording)`` to a channel."""
    table = np.zeros(len(rows) * COUNT, row_dtype(1))
    table["shown"][:, 0, channel] = np.concatenate([values(one) for one in rows])
    table.tofile(path)
    return str(path)


def test_noise_is_what_the_fitted_nominal_leaves() -> None:
    found = noise_of(samples(3))
    for channel, size in (("transmission_error", 1.2e-6), ("motor_torque", 0.03), ("temperature", 0.02)):
        assert np.mean([row[channel] for row in found.values()]) == pytest.approx(size, rel=0.1)


def test_strength_and_place_are_of_what_no_calibration_takes(tmp_path: Path) -> None:
    plant = "rh380n?conceal=4&kinds=stribeck&weak=0"
    rows = samples(3)
    noise = noise_of(rows)

    def once(one: dict[str, Any]) -> Any:
        return np.full(COUNT, -0.3 * (one["id"] == "0007"))

    truth = truth_of(plant, ledger(tmp_path / "a", rows, 1, once), rows, noise, "through-000", 1, "x")
    (effect,) = truth["effects"]
    assert (effect["effect"], effect["status"], truth["verdict"]) == ("friction.stribeck", "named", "mismatch")
    assert effect["strength"] > 1.0
    assert effect["location"]["measured_direction"] in ("negative", "both")
    energies = effect["location"]["recordings"]
    assert max(energies, key=lambda name: energies[name]) == "0007"
    # what a friction parameter can take is no effect: the same drag at every speed
    plain = ledger(tmp_path / "b", rows, 1, lambda one: 0.3 * one["side"])
    (gone,) = truth_of(plant, plain, rows, noise, "through-000", 1, "x")["effects"]
    assert gone["strength"] < 0.01


def test_weak_orders_are_told_and_nothing_is_a_match(tmp_path: Path) -> None:
    rows = samples(3)
    noise = noise_of(rows)
    np.zeros(len(rows) * COUNT, row_dtype(0)).tofile(tmp_path / "none")
    truth = truth_of("rh380n?conceal=4&kinds=", str(tmp_path / "none"), rows, noise, "through-000", 1, "x")
    (weak,) = truth["effects"]
    assert weak["effect"] == "te.harmonic"
    assert len(weak["location"]["orders"]) == 24
    bare = truth_of("rh380n?conceal=4&kinds=&weak=0", str(tmp_path / "none"), rows, noise, "through-000", 1, "x")
    assert bare["verdict"] == "match"
    assert concealed_in("rh380n?conceal=4&kinds=dahl")["concealed"][0]["effect"] == "friction.presliding"


def test_only_what_is_compared_counts(tmp_path: Path) -> None:
    """Friction of a bench that stands, ripple, and the transmission error of a sudden change are no one's finding."""
    rows = samples(3)
    rows[0]["rate"] = np.zeros(COUNT)
    rows[0]["steady"] = np.zeros(COUNT, dtype=bool)
    rows[1]["rate"] = 0.17 * np.sin(0.12 * np.arange(COUNT))
    rows[1]["steady"] = np.zeros(COUNT, dtype=bool)
    noise = noise_of(rows)
    name = "rh380n?conceal=4&kinds={}&weak=0"

    def energies(kind: str, channel: int, values: Any) -> tuple[float, dict[str, float]]:
        folder = tmp_path / kind
        truth = truth_of(name.format(kind), ledger(folder, rows, channel, values), rows, noise, "through-000", 1, "x")
        (effect,) = truth["effects"]
        return float(effect["strength"]), dict(effect["location"]["recordings"])

    def at_rest_or_in(one: dict[str, Any]) -> Any:
        return np.full(COUNT, 0.3 * (one["id"] == "0000") + 0.3 * (one["id"] == "0007"))

    _, friction = energies("dahl", 1, at_rest_or_in)
    assert "0000" not in friction
    assert max(friction, key=lambda r: friction[r]) == "0007"
    strength, _ = energies("delay", 2, lambda one: 5.0 * np.sin(150.0 * one["load_angle"] + float(one["id"])))
    assert strength < 0.5
    _, twist = energies("film", 0, lambda one: 1e-5 * (one["id"] in ("0001", "0007")) * np.sin(777.0 * one["theta"]))
    assert max(twist, key=lambda r: twist[r]) == "0007"
    assert twist.get("0001", 0.0) < 0.5 * twist["0007"]


def test_a_motor_that_is_worth_more_torque_than_it_says_shows_in_what_the_load_takes(tmp_path: Path) -> None:
    """Torque over ratio has no parameter that a calibration could turn."""
    rows = samples(3)
    path = ledger(tmp_path / "a", rows, 1, lambda one: 0.05 * one["torque"] / 185.0)
    (effect,) = truth_of("rh380n?conceal=4&kinds=torque_gain&weak=0", path, rows, noise_of(rows), "t", 1, "x")[
        "effects"
    ]
    assert effect["strength"] > 1.0


def test_what_is_drawn_too_small_is_told_apart(tmp_path: Path) -> None:
    rows = samples(3)
    noise = noise_of(rows)

    def effect_of_size(size: float) -> dict[str, Any]:
        path = ledger(tmp_path / f"{size}", rows, 1, lambda one: np.full(COUNT, size * (abs(one["rate"][0]) < 0.05)))
        return dict(truth_of("rh380n?conceal=4&kinds=stribeck&weak=0", path, rows, noise, "t", 1, "x")["effects"][0])

    small, large = effect_of_size(0.002), effect_of_size(0.05)
    assert (small["too_faint"], large["too_faint"]) == (True, False)
