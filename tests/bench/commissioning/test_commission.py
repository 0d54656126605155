"""A bench that is right passes; each thing that is wrong is named before anything moves fast."""

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.commissioning import Commissioned, commission, require_commissioned, slaves
from bench.commissioning.guide import Nobody
from bench.commissioning.record import digest, record_path
from bench.commissioning.session import STEPS
from bench.commissioning.trial import slow
from bench.commissioning.zero import mark, require_zero
from bench.configuration import BenchFile, load_bench, on_interface, parse_bench
from bench.cycle.assembly import Assembly, assemble
from bench.cycle.rig import Rig
from bench.errors import BenchError, ConfigurationError, DeviceError, LimitError
from bench.safety import Act, LatchFile, Standing
from bench.safety.paths import VARIABLE


class Refusing(Nobody):
    """Says no to the question that holds a word."""

    def __init__(self, word: str) -> None:
        super().__init__()
        self.word = word

    def ask(self, question: str) -> bool:
        return self.word not in question


@pytest.fixture(scope="module")
def passed() -> Commissioned:
    return commission(load_bench("rh380n"), Nobody(), "me")


def changed(old: str, new: str, count: int = 1) -> BenchFile:
    text = load_bench("rh380n").text
    assert old in text
    return parse_bench(text.replace(old, new, count), "changed")


@pytest.mark.parametrize("name", ["rh380n", "rv80n"])
def test_a_bench_that_is_right_passes_every_step(name: str) -> None:
    guide = Nobody()
    record = commission(load_bench(name), guide, "me", seed=4)
    assert [step.name for step in record.steps] == [*(step.name for step in STEPS), "zero"]
    assert record.zero.spread < 1e-5
    assert record.digest == digest(load_bench(name).configuration)
    seen = record.steps[0].values
    assert {role for role, values in seen.items() if values is None} <= {"safety_terminal"}
    assert all(values["vendor"] and values["product"] for values in seen.values() if values is not None)
    assert "watchdog_s" not in record.steps[1].values
    torques = record.steps[6].values
    assert torques["load_torque"] == pytest.approx(torques["load_nm"], rel=0.1)
    assert len(guide.said) >= 2 * len(record.steps) - 1


WRONG = [
    ("product = 0x0402_0D01", "product = 0x0402_0D02", "input_drive"),
    ('nominal_torque = "17.5 N*m"', 'nominal_torque = "18 N*m"', "rated torque"),
    (
        "polarity = -1                        # the load motor faces the input motor",
        "polarity = 1",
        "polarity of the load",
    ),
    ("torque_polarity = 1 ", "torque_polarity = -1 ", "torque_polarity of the load drive"),
    ('rated_voltage = "10 V"\npolarity = 1', 'rated_voltage = "10 V"\npolarity = -1', "polarity of the torque sensor"),
    ('rated_voltage = "10 V"', 'rated_voltage = "5 V"', "scale of the torque sensor"),
    (
        'polarity = 1\noptions = { mode = "csv" }',
        'polarity = 1\ntorque_polarity = -1\noptions = { mode = "csv" }',
        "input drive",
    ),
    ("[limits]", '[commissioning]\nlargest_tare = "1 N*m"\n\n[limits]', "zero is 3"),
    (
        'active_low = ["emergency_stop", "safe_torque_off"]',
        'active_low = ["safe_torque_off"]',
        "emergency stop circuit",
    ),
    ("ratio = 185.0\nteeth = { z1 = 24, z2 = 96, z3 = 45, z4 = 46 }", "ratio = 170.0", "ratio"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), WRONG, ids=[wrong[2] for wrong in WRONG])
def test_what_is_wrong_is_named(old: str, new: str, sentence: str) -> None:
    with pytest.raises(BenchError, match=re.escape(sentence)):
        commission(changed(old, new), Nobody(), "me")


@pytest.mark.parametrize(("word", "sentence"), [("clear", "did not want"), ("direction", "wrong way")])
def test_a_no_of_the_operator_ends_it(word: str, sentence: str) -> None:
    with pytest.raises(BenchError, match=sentence):
        commission(load_bench("rh380n"), Refusing(word), "me")


def test_a_brake_is_pushed_against_and_must_hold(tmp_path: Path) -> None:
    plant = Path("fakes/plants/rh380n.toml").read_text("utf-8")
    braked = tmp_path / "braked.toml"
    braked.write_text(plant.replace("[load_motor]", "brake_torque = 30.0\n\n[load_motor]", 1))
    text = load_bench("rh380n").text
    with_brake = text.replace('inertia = "0.0029 kg*m^2"', 'brake_torque = "30 N*m"\ninertia = "0.0029 kg*m^2"')
    good = with_brake.replace('plant = "rh380n"', f'plant = "{braked}"')
    record = commission(parse_bench(good, "braked"), Nobody(), "me")
    assert "holds 130 N·m" in next(step.text for step in record.steps if step.name == "brakes")
    # the plant that ships has no brake: the gearbox' own friction would hold a little, not this
    heavy = with_brake + '\n[commissioning]\nload_torque = "500 N*m"\n'
    with pytest.raises(BenchError, match="brake does not hold"):
        commission(parse_bench(heavy, "no brake"), Nobody(), "me")


def test_drives_get_a_share_of_their_limits_meanwhile() -> None:
    file = load_bench("rh380n")
    tried, limits = slow(file).configuration.limits, file.configuration.limits
    assert tried.motor_torque == 0.25 * limits.motor_torque
    assert tried.motor_speed == 40.0
    assert slow(file).text == file.text


def test_a_wired_bench_runs_only_after_it_has_passed(
    passed: Commissioned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    assert require_commissioned(load_bench("rh380n").configuration) is None
    bench = on_interface(load_bench("rh380n"), "eth1").configuration
    with pytest.raises(LimitError, match="bench commission --bus eth1"):
        require_commissioned(bench)
    path = record_path(bench)
    assert path is not None
    passed.save(path)
    with pytest.raises(LimitError, match="again"):  # it was another bench: one in this process
        require_commissioned(bench)
    record = Commissioned(bench.name, "eth1", digest(bench), passed.at, "me", passed.steps, passed.zero)
    record.save(path)
    assert require_commissioned(bench) == record
    faster = on_interface(changed('motor_speed = "220 rad/s"', 'motor_speed = "221 rad/s"'), "eth1").configuration
    with pytest.raises(LimitError, match="limits"):
        require_commissioned(faster)
    content = json.loads(path.read_text())
    content["zero"]["motor_angle"] += 0.01
    path.write_text(json.dumps(content))
    with pytest.raises(ConfigurationError, match="signed"):
        require_commissioned(bench)


def test_a_power_cut_takes_the_zero_away(passed: Commissioned) -> None:
    file = load_bench("rh380n")
    assembly = assemble(file.configuration, seed=0, real_time=False)
    with Rig(file, assembly=assembly, zero=passed.zero) as rig:
        assert rig.zero_id == passed.zero.zero_id
        mark(rig, passed.zero.marker, file.configuration.commissioning.marker)
        require_zero(rig, passed.zero)
        assembly.master.bench.drive("input_drive").dictionary.reset()
        with pytest.raises(LimitError, match=r"input drive has lost its power.*--zero"):
            require_zero(rig, passed.zero)


def test_the_zero_makes_both_encoders_agree(passed: Commissioned) -> None:
    file = load_bench("rh380n")
    with Rig(file) as plain, Rig(file, zero=passed.zero) as zeroed:
        shift = zeroed.zeros.motor_angle - plain.zeros.motor_angle
    assert shift == pytest.approx(passed.zero.motor_angle)
    assert 0 < abs(shift) < 0.1


def test_nobody_may_say_yes_for_a_real_bench(tmp_path: Path) -> None:
    path = tmp_path / "real.toml"
    text = load_bench("rh380n").text.replace('master = "emulated"', 'master = "soem"').replace('plant = "rh380n"\n', "")
    path.write_text(text)
    app, runner = make_app(), CliRunner()
    refused = runner.invoke(app, ["commission", "--bench", str(path), "--yes"])
    assert "emulated plants only" in str(refused.exception)
    refused = runner.invoke(app, ["commission"])
    assert "terminal" in str(refused.exception)


class Pressing(Nobody):
    """A person who does what they are told with the emergency stop, or does not."""

    has_hands = True

    def __init__(self, obedient: bool = True) -> None:
        super().__init__()
        self.master: Any = None
        self.obedient = obedient

    def show(self, text: str) -> None:
        super().show(text)
        if self.obedient and text.startswith("Press"):
            self.master.faults.apply("emergency_stop", value=0.1)
        elif text.startswith("Release"):
            self.master.faults.clear("emergency_stop")


@pytest.mark.parametrize("obedient", [True, False])
def test_with_a_person_the_emergency_stop_is_pressed(obedient: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    guide = Pressing(obedient)

    def keep(*arguments: Any, **more: Any) -> Assembly:
        made = assemble(*arguments, **more)
        guide.master = made.master
        return made

    monkeypatch.setattr("bench.cycle.rig.assemble", keep)
    if obedient:
        record = commission(load_bench("rh380n"), guide, "me")
        assert "opens its circuit" in next(step.text for step in record.steps if step.name == "safety")
    else:
        with pytest.raises(BenchError, match="does not say pressed"):
            commission(load_bench("rh380n"), guide, "me")


def test_a_bench_that_was_stopped_is_not_tried_out_before_its_three_acts(monkeypatch: pytest.MonkeyPatch) -> None:
    latch = LatchFile()
    latch.write(latch.read().stopped("MOTOR_SPEED", "too fast", ""))
    monkeypatch.setattr("bench.commissioning.session.latch_of", lambda bench: latch)
    with pytest.raises(LimitError, match="too fast"):
        commission(load_bench("rh380n"), Nobody(), "me")
    for act in (Act.ACKNOWLEDGE, Act.RESET):
        latch.act(act, "me")
    with pytest.raises(LimitError, match="too fast"):
        commission(load_bench("rh380n"), Refusing("again"), "me")
    commission(load_bench("rh380n"), Nobody(), "me", seed=1)
    assert latch.read().standing is Standing.CLEAR


def test_a_stop_while_a_bench_is_tried_out_is_latched(monkeypatch: pytest.MonkeyPatch) -> None:
    latch = LatchFile()
    monkeypatch.setattr("bench.commissioning.session.latch_of", lambda bench: latch)
    fast = changed('velocity_error = "6 rad/s"', 'velocity_error = "0.01 rad/s"')
    with pytest.raises(LimitError, match="while it was tried out"):
        commission(fast, Nobody(), "me")
    assert latch.read().cause == "VELOCITY_ERROR"


def test_a_slave_that_says_it_is_another_is_refused() -> None:
    slave = SimpleNamespace(role="x", vendor=1, product=2)
    sdo = SimpleNamespace(read=lambda index, subindex, kind: 7)
    bus = SimpleNamespace(specs=[SimpleNamespace(name="x", coe=True)], sdo=lambda _: sdo)
    assembly = SimpleNamespace(bus=bus)
    trial: Any = SimpleNamespace(
        rig=SimpleNamespace(link=SimpleNamespace(assembly=assembly)),
        bench=SimpleNamespace(bus=SimpleNamespace(slaves=[slave])),
        values={},
    )
    with pytest.raises(DeviceError, match="00000007 00000007, the bench file has 00000001 00000002"):
        slaves.identities(trial)
    assert trial.values["x"]["serial"] == 7, "what was read, not what was wanted"
