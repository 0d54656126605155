"""By hand over HTTP: for whoever holds the controls, on a free bench; silence lets go, a zero is told as measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from bench.campaigns.operator.directions import Directions
from bench.configuration import load_bench
from bench.errors import DeviceError
from bench.service.process.hold import SILENT_S, Hold
from bench.service.process.obey import Obedience
from bench.service.process.tare import tare
from tests.bench.service.conftest import Client
from tests.bench.service.test_obey import Reporter


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


def test_nothing_is_held_before_the_first_word(clock: Clock) -> None:
    hold = Hold(clock)
    clock.now += 60.0
    assert not hold.is_held()
    hold.still()
    assert hold.is_held()


def test_silence_lets_go_for_good(clock: Clock) -> None:
    hold = Hold(clock)
    for _ in range(20):
        hold.still()
        clock.now += 0.9 * SILENT_S
        assert hold.is_held()
    clock.now += 0.2 * SILENT_S
    # late, and nobody had looked meanwhile: it was let go of all the same
    hold.still()
    assert not hold.is_held()


def test_while_the_drives_are_brought_up_only_the_last_word_counts(clock: Clock) -> None:
    hold = Hold(clock)
    hold.still()
    clock.now += 3.0 * SILENT_S
    assert not hold.is_held()
    hold.still()
    assert hold.is_held()
    clock.now += 1.1 * SILENT_S
    assert not hold.is_held()
    hold.still()
    assert not hold.is_held()


def test_a_button_that_is_let_go_is_not_held_again(clock: Clock) -> None:
    hold = Hold(clock)
    hold.still()
    hold.let_go()
    hold.still()
    assert not hold.is_held()


def test_only_words_for_this_run_hold_it(clock: Clock) -> None:
    hold = Hold(clock)
    obey = Obedience("run-1", Directions(), Reporter(), hold)
    obey({"do": "hold", "run": "run-2"})
    assert not hold.is_held()
    obey({"do": "hold", "run": "run-1"})
    assert hold.is_held()
    obey({"do": "let_go", "run": "run-1"})
    assert not hold.is_held()


def jog(client: Client, status: int = 200, velocity: float = 0.02, secret: str | None = None) -> Any:
    return client.ask("jog", status, secret=client.secret if secret is None else secret, velocity=velocity)


def test_it_takes_the_controls_and_a_slow_speed(client: Client) -> None:
    assert "nobody holds the controls" in jog(client, 403, secret="nobody")["problem"]
    client.take()
    assert "at most" in jog(client, 409, velocity=0.5)["problem"]
    assert "at most" in jog(client, 409, velocity=0.0)["problem"]
    assert client.launcher.jobs == []


def test_a_motion_is_begun_and_held_by_whoever_holds_the_controls(client: Client) -> None:
    client.take()
    run = jog(client, velocity=-0.02)["id"]
    client.until(lambda: client.launcher.jobs)
    assert client.launcher.jobs[0]["by_hand"] == -0.02
    assert client.launcher.jobs[0]["real_time"] is True
    held = {"secret": client.secret, "run": run}
    assert client.http.post("/api/jog/hold", json=held).json() == {"done": "held"}
    assert client.http.post("/api/jog/hold", json=held | {"held": False}).json() == {"done": "let go"}
    assert client.http.post("/api/jog/hold", json=held | {"secret": "another"}).status_code == 403
    assert "over" in client.http.post("/api/jog/hold", json=held | {"run": "none"}).json()["problem"]
    # one at a time, and a second one does not wait in the queue
    client.until(lambda: "jog" not in client.state("state")["allowed"])
    assert "not possible now" in jog(client, 409)["problem"]
    assert any(entry["act"] == "by_hand" for entry in client.get("book"))


def test_nothing_is_moved_by_hand_while_a_campaign_waits(client: Client) -> None:
    client.take()
    assert "jog" in client.state("state")["allowed"]
    client.ask("runs", secret=client.secret, name="Ann", campaign="quick")
    client.until(lambda: "jog" not in client.state("state")["allowed"])


def test_the_state_says_how_fast(client: Client) -> None:
    assert client.state("about")["jog_speed"] == pytest.approx(0.0595, rel=0.01)


def test_the_sensor_is_tared_by_whoever_holds_the_controls(client: Client) -> None:
    assert "nobody holds the controls" in client.ask("tare", 403, secret="nobody")["problem"]
    client.take()
    run = client.ask("tare", secret=client.secret)["id"]
    client.until(lambda: client.launcher.jobs)
    assert client.launcher.jobs[0]["tares"] is True
    client.until(lambda: "tare" not in client.state("state")["allowed"])
    assert "not possible now" in client.ask("tare", 409, secret=client.secret)["problem"]
    assert any(entry["act"] == "tare" and entry["run"] == run for entry in client.get("book"))
    for process in client.launcher.processes:
        process.kill()
    client.until(lambda: client.state("runs")["runs"][-1]["state"] == "ended")
    # it is no campaign that could go on
    client.until(lambda: client.state("state")["alarms"])
    number = client.state("state")["alarms"][0]["number"]
    client.ask(f"alarms/{number}/acknowledge", secret=client.secret)
    assert "does not go on" in client.ask(f"runs/{run}/again", 409, secret=client.secret)["problem"]


@pytest.fixture
def shortly(monkeypatch: pytest.MonkeyPatch) -> float:
    """So long the sensor is read here, s: a quarter of a taring is the same taring."""
    monkeypatch.setattr("bench.service.process.tare.TARE_S", 0.5)
    return 0.5


def test_the_zero_is_told_as_measured(tmp_path: Path, shortly: float) -> None:
    file = load_bench("rh380n")
    end = tare(file, tmp_path, lambda: False)
    assert end["kind"] == "finished"
    found = end["tare"]
    assert found["readings"] == round(shortly / file.configuration.bus.cycle_time)
    assert 0.0 < found["deviation"] < 1.0
    assert f"{found['zero']:+.3g} N·m" in end["text"]
    assert tare(file, tmp_path, lambda: True)["kind"] == "interrupted"


@pytest.mark.usefixtures("shortly")
def test_a_loaded_sensor_is_not_tared(tmp_path: Path) -> None:
    file = load_bench("rh380n")
    configuration = file.configuration
    strict = configuration.commissioning.model_copy(update={"largest_tare": 1e-9})
    with pytest.raises(DeviceError, match="take the load off"):
        tare(
            replace(file, configuration=configuration.model_copy(update={"commissioning": strict})),
            tmp_path,
            lambda: False,
        )
