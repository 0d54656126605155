"""A plant that plays a simulation file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.simulation.model import Simulation
from bench.simulation.terms.base import Form
from bench.simulation.terms.table import LIBRARY
from fakes.plant import Plant, PlantError, PlantTruth, read_plant
from fakes.plant.overlay import frame_of, value
from fakes.plant.simulation import of_simulation
from tests.fakes.plant.motion import bring_up, commands, quiet, ramped

GEARBOX = {"ratio": 185.0, "z1": 24, "z2": 96, "z3": 45, "z4": 46}


@pytest.fixture(scope="module")
def truth() -> PlantTruth:
    return quiet(read_plant("rh380n"))


def written(folder: Path, terms: list[dict[str, Any]]) -> Path:
    """Write a simulation file with these terms."""
    path = folder / "model.json"
    table = {"format": "bench-simulation", "format_version": "1.0", "gearbox": GEARBOX, "terms": terms}
    path.write_text(json.dumps(table), encoding="utf-8")
    return path


def parameters(**values: float) -> dict[str, dict[str, Any]]:
    return {symbol: {"value": value, "unit": "1"} for symbol, value in values.items()}


def test_series_of_a_file_is_played(tmp_path: Path, truth: PlantTruth) -> None:
    table = truth.without_weak_orders().te_coefficients()
    path = written(tmp_path, [{"effect": "te.fourier", "parameters": table, "orders": [1, 3, 46]}])
    played = Plant.from_simulation(path).truth
    theta = np.linspace(0, 6, 200)
    state = np.array(400.0), np.array(-0.08), np.array(33.0)
    assert played.transmission_error.orders.tolist() == [1.0, 3.0, 46.0]
    full = truth.without_weak_orders().te(theta, *state)
    part = played.te(theta, *state)
    assert np.std(full - part) > 5e-6
    everything = written(tmp_path, [{"effect": "te.fourier", "parameters": table}])
    np.testing.assert_allclose(Plant.from_simulation(everything).truth.te(theta, *state), full, atol=1e-12)


def test_nominal_parameters_are_taken_over(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        [
            {"effect": "friction.coulomb", "parameters": parameters(f_c=0.8)},
            {"effect": "friction.load_dependent", "enabled": False},
            {"effect": "thermal.loss_heating", "parameters": {"1/C": 5e-5}},
            {"effect": "thermal.convection", "parameters": {"1/(R*C)": 1e-4, "(T_amb-25)/(R*C)": -3e-4}},
            {"effect": "load.bearing_friction", "parameters": parameters(f_b=5.0)},
            {"effect": "thermal.ambient_drift", "enabled": True, "parameters": {"d_1": 1e-4}},
            {"effect": "thermal.sensor_lag", "enabled": True, "parameters": {"1/C": 5e-5, "tau_s": 30.0}},
        ],
    )
    truth = Plant.from_simulation(path).truth
    assert (truth.friction.coulomb, truth.friction.load_dependent) == (0.8, 0.0)
    assert truth.friction.viscous == 0.006
    assert truth.heat.capacity == pytest.approx(20e3)
    assert truth.heat.resistance == pytest.approx(0.5)
    assert truth.heat.ambient == pytest.approx(22.0)
    assert truth.load_side.bearing_friction == 5.0
    assert truth.heat.ambient_rate == pytest.approx(1e-4 * 20e3 * 0.5 / 3600.0)
    assert truth.lubricant_sensor.lag == 30.0


def test_stribeck_is_felt_with_its_heat(tmp_path: Path) -> None:
    plain = Plant.from_simulation(written(tmp_path, []))
    term = {"effect": "friction.stribeck", "form": "exponential", "parameters": parameters(f_s=0.4, w_s=10.0)}
    extra = Plant.from_simulation(written(tmp_path, [term]))
    means, losses = [], []
    for plant in (plain, extra):
        bring_up(plant, 8.0, 0.0)
        before = plant.state["loss_gearbox"]
        means.append(plant.step(commands(1.0, 8.0, 0.0))["input_torque"].mean())
        losses.append(plant.state["loss_gearbox"] - before)
    expected = 0.4 * np.exp(-0.8)
    assert means[1] - means[0] == pytest.approx(expected, abs=0.01)
    assert losses[1] - losses[0] == pytest.approx(expected * 8.0, rel=0.05)


def test_harmonic_and_sensor_gain_show_where_they_belong(tmp_path: Path) -> None:
    plain = Plant.from_simulation(written(tmp_path, []), seed=1)
    terms = [
        {"effect": "te.harmonic", "parameters": parameters(c=2e-5, s=0.0, f=37.0)},
        {"effect": "sensor.torque_gain", "parameters": parameters(g_s=0.02)},
    ]
    path = written(tmp_path, terms)
    extra = Plant.from_simulation(path, seed=1)
    whole = Plant.from_simulation(path, seed=1)
    for plant in (plain, extra, whole):
        bring_up(plant, 30.0, 500.0)
    rows = commands(0.5, 30.0, 500.0)
    without, with_terms = plain.step(rows), extra.step(rows)
    parts = np.concatenate([whole.step(rows[:1]), whole.step(rows[1:400]), whole.step(rows[400:])])
    assert parts.tobytes() == with_terms.tobytes()
    q = -(with_terms["load_position"] - without["load_position"]) / 2**25 * 2 * np.pi
    theta = without["input_position"] / 8192 * 2 * np.pi / 185.0
    np.testing.assert_allclose(q, 2e-5 * np.cos(37.0 * theta), atol=5e-7)
    gain = (with_terms["torque_adc"] - without["torque_adc"]) * 10e3 / 32768
    assert gain.mean() == pytest.approx(0.02 * 508.0, abs=0.5)


def test_a_law_multiplies_the_series(tmp_path: Path, truth: PlantTruth) -> None:
    plain_truth = truth.without_weak_orders()
    series = {"effect": "te.fourier", "parameters": plain_truth.te_coefficients(), "orders": [46]}
    law = {"form": "second_order", "point": [12.0, 0.1], "orders": [46]}
    term = {"effect": "te.resonance", "law": law}
    plants = [Plant.from_simulation(written(tmp_path, terms), seed=1) for terms in ([series], [series, term])]
    for plant in plants:
        bring_up(plant, 30.0, 0.0)
    plain, resonant = (plant.step(commands(0.5, 30.0, 0.0)) for plant in plants)
    change = -(resonant["load_position"] - plain["load_position"]) / 2**25 * 2 * np.pi
    frequency = 46 * 30.0 / 185.0
    r = frequency / 12.0
    factor = 1.0 / (1.0 - r**2 + 2j * 0.1 * r)
    size = np.abs(plants[0].truth.transmission_error.amplitude[0, 0, 9])
    assert np.ptp(change) / 2 == pytest.approx(np.abs(factor - 1.0) * size, rel=0.35)


def test_a_delay_of_the_torque_shows_where_it_changes_however_cycles_are_cut(tmp_path: Path) -> None:
    skew = {"effect": "sensor.timing_skew", "channels": ["load_torque"], "parameters": parameters(delta=0.02)}
    other = tmp_path / "plain"
    other.mkdir()
    path = written(tmp_path, [skew])
    plain, whole, parts = (Plant.from_simulation(p, seed=1) for p in (written(other, []), path, path))
    rows = commands(0.5, 10.0, 0.0)
    rows["load_torque"] = np.linspace(0.0, 200.0, rows.size)
    for plant in (plain, whole, parts):
        bring_up(plant, 10.0, 0.0)
    before = parts.snapshot()
    once = np.concatenate([parts.step(rows[:1]), parts.step(rows[1:7]), parts.step(rows[7:])])
    parts.restore(before)
    again = np.concatenate([parts.step(rows[:300]), parts.step(rows[300:])])
    reference, delayed = plain.step(rows), whole.step(rows)
    assert once.tobytes() == again.tobytes() == delayed.tobytes()
    change = (delayed["torque_adc"] - reference["torque_adc"])[200:] * 10e3 / 32768
    assert abs(change.mean()) == pytest.approx(0.02 * 400.0, rel=0.3)


def test_further_rows_of_a_term_are_played_and_orders_of_the_series_once(tmp_path: Path, truth: PlantTruth) -> None:
    table = truth.without_weak_orders().te_coefficients()
    series = {"effect": "te.fourier", "parameters": table}
    ripple = {"effect": "motor.torque_ripple", "form": "ripple", "parameters": parameters(a_rc=0.1, a_rs=0.0, n=24.0)}
    more = {**ripple, "also": [{"form": "ripple", "parameters": parameters(a_rc=0.05, a_rs=0.0, n=48.0)}]}
    known = {"effect": "te.harmonic", "orders": [46]}
    effects = Plant.from_simulation(written(tmp_path, [series, more, known])).truth.effects
    assert [(e.effect, e.linear[0], e.nonlinear[0]) for e in effects] == [
        ("motor.torque_ripple", 0.1, 24.0),
        ("motor.torque_ripple", 0.05, 48.0),
    ]


@pytest.mark.parametrize(
    ("term", "message"),
    [
        (
            {
                "effect": "unknown",
                "form": "table",
                "channels": ["motor_torque"],
                "over": ["aux/oil"],
                "times": "d",
                "knots": [[0.0, 1.0]],
                "values": [0.0, 0.1],
            },
            "no quantity 'aux/oil'",
        ),
        ({"effect": "magic.smoke", "parameters": {"a": 1.0}}, "no such term"),
        ({"effect": "friction.stribeck", "parameters": {"f_s": 0.4}}, "not those of any of its forms"),
        ({"effect": "motor.inertia", "enabled": False}, "cannot be switched off"),
    ],
)
def test_what_cannot_be_played_is_refused(tmp_path: Path, term: dict[str, Any], message: str) -> None:
    with pytest.raises(PlantError, match=message):
        Plant.from_simulation(written(tmp_path, [term]))


WITH_MEMORY = [
    (effect, channel, form)
    for effect in ("te.hysteresis", "friction.presliding", "sensor.torque_hysteresis")
    for channel, forms in LIBRARY[effect].forms.items()
    for form in forms
]
WIDTH = {"w": 60.0, "w_h": 60.0, "s": 0.004, "s_d": 2.0, "r": 0.5, "w_b": 120.0, "w_h_b": 120.0, "rho": 3.0, "k": 0.5}
WIDTH |= {"b_s": 0.5, "w_s": 6.0}
SIZE = {"transmission_error": 2e-5, "motor_torque": 0.2, "load_torque": 20.0}
UNITS = {"load_position": -(2 * np.pi) / 2**25, "input_torque": 1.0, "torque_adc": 10e3 / 32768}
"""what of the measurements each of these channels is, in its unit"""


def remembering(effect: str, channel: str, form: Form) -> dict[str, Any]:
    """A row of a simulation file with a term that remembers its path."""
    values = {s.symbol: SIZE[channel] for s in form.linear} | {s.symbol: WIDTH[s.symbol] for s in form.nonlinear}
    return {"form": form.name, "channels": [channel], "parameters": parameters(**values)}


def to_and_fro() -> NDArray[Any]:
    """A reversal under a load that rises, falls and crosses zero."""
    return np.concatenate(
        [
            ramped(0.4, 0.0, 12.0, 0.0, 250.0),
            ramped(0.4, 12.0, 0.0, 250.0, -150.0),
            ramped(0.4, 0.0, -12.0, -150.0, 80.0),
            ramped(0.2, -12.0, -12.0, 80.0, 80.0),
        ]
    )


def test_terms_with_a_memory_go_on_from_block_to_block_and_from_a_snapshot(tmp_path: Path) -> None:
    rows: dict[str, list[dict[str, Any]]] = {}
    for effect, channel, form in WITH_MEMORY:
        rows.setdefault(effect, []).append(remembering(effect, channel, form))
    table = {"form": "table", "over": ["since_reversal"], "times": "d*reversed", "knots": [[-5.0, -1.0]]}
    heat = {"form": "table", "over": ["speed"], "times": "1", "knots": [[0.0, 0.1]], "channels": ["temperature"]}
    warm = {"form": "table", "over": ["warming"], "times": "1", "knots": [[-1.0, 1.0]], "channels": ["load_torque"]}
    taken = {"form": "table", "over": ["taken_along_50mrad"], "times": "1", "knots": [[-0.05, 0.05]]}
    impulse = {"form": "table", "over": ["impulse_300Nms"], "times": "1", "knots": [[-300.0, 300.0]]}
    states = [
        {"form": "table", "over": [f"{kind}_30s"], "times": "d", "knots": [[-1.0, 1.0]]}
        for kind in ("recent_speed", "recent_load", "recent_torque", "recent_loss", "recent_load_motor")
    ]
    rows["unknown"] = [
        {**taken, "channels": ["load_torque"], "values": [-8.0, 8.0]},
        *({**state, "channels": ["motor_torque"], "values": [-0.1, 0.1]} for state in states),
        {**table, "channels": ["motor_torque"], "values": [0.3, 0.0]},
        {**impulse, "channels": ["transmission_error"], "values": [-1e-5, 1e-5]},
        {**heat, "values": [0.0, 0.2]},
        {**warm, "values": [-500.0, 500.0]},
    ]
    terms = [{"effect": effect, **parameters[0], "also": parameters[1:]} for effect, parameters in rows.items()]
    plant = Plant.from_simulation(written(tmp_path, terms), seed=3)
    plant.step(to_and_fro()[:300])
    before = plant.snapshot()
    driven = to_and_fro()
    whole = plant.step(driven)
    plant.restore(before)
    cut = np.concatenate([plant.step(driven[:1]), plant.step(driven[1:777]), plant.step(driven[777:])])
    plant.restore(before)
    single = np.concatenate([plant.step(driven[k : k + 1]) for k in range(200)])
    assert cut.tobytes() == whole.tobytes()
    assert single.tobytes() == whole[:200].tobytes()


def test_what_remembers_its_path_shows_by_where_it_came_from(tmp_path: Path) -> None:
    chosen = {"te.hysteresis": "play", "friction.presliding": "dahl", "sensor.torque_hysteresis": "dahl_kept"}
    terms = [
        {"effect": effect, **remembering(effect, channel, form)}
        for effect, channel, form in WITH_MEMORY
        if form.name == chosen[effect]
    ]
    plain = Plant.from_simulation(written(tmp_path, []), seed=1)
    with_term = Plant.from_simulation(written(tmp_path, terms), seed=1)

    def added(rows: NDArray[Any]) -> dict[str, float]:
        """What the terms add at the end of some cycles, over their sizes."""
        last = {name: with_term.step(rows)[-50:][name] - plain.step(rows)[-50:][name] for name in UNITS}
        channels = zip(SIZE, UNITS.items(), strict=True)
        return {channel: float(last[name].mean()) * unit / SIZE[channel] for channel, (name, unit) in channels}

    added(ramped(1.0, 0.0, 12.0, 0.0, 250.0))
    rising = added(ramped(1.0, 12.0, 12.0, 250.0, 500.0))
    falling = added(ramped(1.0, 12.0, 12.0, 500.0, 250.0))
    for channel in ("transmission_error", "load_torque"):
        assert (rising[channel], falling[channel]) == pytest.approx((1.0, -1.0), abs=0.06)
    assert falling["motor_torque"] == pytest.approx(0.0, abs=0.02)
    # a tenth of a second after the reversal the shaft has turned by less than the distance that friction needs
    just_turned = added(np.concatenate([ramped(0.2, 12.0, 0.0, 250.0, 250.0), ramped(0.1, 0.0, -12.0, 250.0, 250.0)]))
    assert 1.0 < just_turned["motor_torque"] < 2.0
    assert added(commands(2.0, -12.0, 250.0))["motor_torque"] == pytest.approx(0.0, abs=0.02)


def test_every_term_of_the_library_can_be_played(truth: PlantTruth) -> None:
    frame = frame_of(4, 185.0, {"torque_level": 100.0, "torque": 100.0, "theta": [0.0, 0.1, 0.2, 0.3]})
    for effect, term in LIBRARY.items():
        if term.nominal or effect == "te.resonance":
            continue
        for channel, forms in term.forms.items():
            for form in forms:
                values = {s.symbol: 0.7 for s in (*form.linear, *form.nonlinear)}
                row = {"form": form.name, "channels": [channel], "parameters": parameters(**values)}
                model = Simulation.from_json(
                    {
                        "format": "bench-simulation",
                        "format_version": "1.0",
                        "gearbox": GEARBOX,
                        "terms": [{"effect": effect, **row}],
                    }
                )
                played = of_simulation(model, truth)
                if effect.startswith("thermal."):
                    assert (played.heat, played.lubricant_sensor) != (truth.heat, truth.lubricant_sensor)
                    continue
                (only,) = played.effects
                assert np.isfinite(value(only, frame)).all()


def test_a_rate_of_the_temperature_adds_up_and_is_forgotten_by_the_cooling(tmp_path: Path) -> None:
    term = {"effect": "unknown", "form": "table", "over": ["speed"], "times": "1", "knots": [[0.0, 0.1]],
            "channels": ["temperature"], "values": [0.0, 0.05]}  # fmt: skip
    folders = [tmp_path / "plain", tmp_path / "own"]
    for folder in folders:
        folder.mkdir()
    plain, with_term = (
        Plant.from_simulation(written(f, t), seed=1) for f, t in zip(folders, ([], [term]), strict=True)
    )
    for plant in (plain, with_term):
        bring_up(plant, 18.5, 0.0)
    rows = commands(4.0, 18.5, 0.0)
    first, second = plain.step(rows)["lubricant_temperature"], with_term.step(rows)["lubricant_temperature"]
    gained = second - first
    assert gained[-1] - gained[0] == pytest.approx(0.05 * 4.0, rel=0.05)


def test_friction_that_is_added_to_the_motor_torque_heats_the_lubricant(tmp_path: Path) -> None:
    heat = {"effect": "thermal.loss_heating", "parameters": {"1/C": 1e-3}}
    term = {"effect": "friction.presliding", "form": "dahl", "parameters": parameters(f_d=0.5, s_d=2.0)}
    plain, with_term = (Plant.from_simulation(written(tmp_path, terms), seed=1) for terms in ([heat], [heat, term]))
    for plant in (plain, with_term):
        bring_up(plant, 20.0, 0.0)
    # after a reversal the springs still push the way they were turned: less work is lost until they are turned round
    rows = np.concatenate([ramped(3.0, 20.0, -20.0, 0.0, 0.0), commands(0.5, -20.0, 0.0)])
    first, second = plain.step(rows), with_term.step(rows)
    omega = plain.state["motor_velocity"], with_term.state["motor_velocity"]
    assert omega[0] == pytest.approx(omega[1])
    angle = plain.truth.input_drive.polarity * first["input_position"] * 2 * np.pi / 2.0**plain.truth.input_encoder.bits
    added = plain.truth.input_drive.polarity * (second["input_torque"] - first["input_torque"])
    work = float(np.sum(added[1:] * np.diff(angle)))
    gained = second["lubricant_temperature"] - first["lubricant_temperature"]
    assert work < -0.5
    assert gained[-1] - gained[0] == pytest.approx(work * 1e-3, rel=0.1, abs=1e-4)


def test_plant_file_may_name_a_simulation(tmp_path: Path) -> None:
    written(tmp_path, [{"effect": "friction.coulomb", "parameters": parameters(f_c=0.9)}])
    path = tmp_path / "played.toml"
    path.write_text('format = "emulated-plant"\nsimulation = "model.json"\nbase = "rh380n"\n', encoding="utf-8")
    assert Plant.from_file(path).truth.friction.coulomb == 0.9
    path.write_text('format = "emulated-plant"\nsimulation = "model.json"\nbase = "rv80n"\n', encoding="utf-8")
    with pytest.raises(PlantError, match="ratio"):
        Plant.from_file(path)
