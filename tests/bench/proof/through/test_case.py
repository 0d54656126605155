"""A case through the bench: what the analyser could see while it runs, and what is kept afterwards."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.errors import ProofError
from bench.proof import analyse, make, seal
from bench.proof.analyse import Job, done_before, prove_case
from bench.proof.through import case, loop
from bench.proof.through.run import CAMPAIGN, plant_named
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from tests.bench.recording import builders

SECRET = "something nobody is told of"


class Examiner:
    """Stands in for the plant's own: a truth with one effect."""

    EVERY = 20

    @staticmethod
    def truth_of(
        plant: str, ledger: str, samples: Any, noise: Any, name: str, seed: int, folder: str
    ) -> dict[str, Any]:
        assert "conceal=" in plant
        assert Path(ledger).parent.is_dir()
        row = {"effect": "unknown", "form": SECRET, "status": "unknown", "channels": ["motor_torque"], "also": []}
        row |= {"strength": 1.0, "in_library": False, "parameters": [], "location": {"conditions": {}, "orders": []}}
        told = {"case": name, "group": "through", "seed": seed, "folder": folder, "verdict": "mismatch"}
        return told | {"effects": [row], "noise_by_recording": {}, "noise_rms": {}, "switched_off": []}


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """What an analyser finds that reads every file it can get at below the exam's folder, and its environment."""
    found: dict[str, Any] = {}

    def run_on(plant: str, folder: Path, seed: int, campaign: Path = CAMPAIGN) -> None:
        folder.mkdir(parents=True)
        (folder / "0001.h5").write_text("numbers")
        Path(plant.rpartition("ledger=")[2]).write_text(SECRET)

    def analysed(folder: Path, target: Path) -> tuple[str, float]:
        files = [path for path in tmp_path.rglob("*") if path.is_file()]
        found["names"] = [path.relative_to(tmp_path).as_posix() for path in files]
        found["text"] = "\n".join(path.read_text() for path in files)
        found["environment"] = case.environment()
        target.mkdir(parents=True)
        (target / "report.json").write_text(json.dumps({"verdict": "match", "findings": []}))
        return "", 1.5

    monkeypatch.setattr(case, "noise", lambda out: {})
    monkeypatch.setattr(case, "load_sealed", lambda: Examiner)
    monkeypatch.setattr(case, "run_on", run_on)
    monkeypatch.setattr(case, "samples_of", lambda folder, every: [])
    monkeypatch.setattr(case, "timed", analysed)
    monkeypatch.setattr(analyse, "recompute", lambda *given: {"predictor": False})
    monkeypatch.setenv("BENCH_TRUTH", SECRET)
    return found


def test_the_analyser_can_read_the_truth_nowhere(seen: dict[str, Any], tmp_path: Path) -> None:
    job = Job("through", "through-003", 7, False, tmp_path)
    outcome = prove_case(job)
    assert outcome.truth["effects"][0]["form"] == SECRET
    assert SECRET not in seen["text"]
    assert "conceal" not in seen["text"]
    assert str(case.plant_seed(7, "through-003")) not in seen["text"] + " ".join(seen["names"])
    assert not [name for name in seen["names"] if name.endswith("through-003.json")]
    # the folder it is given does not follow from the seed
    assert len({name.split("/")[1] for name in seen["names"] if name.startswith(make.RECORDINGS)}) == 1
    assert SECRET in os.environ["BENCH_TRUTH"]
    assert SECRET not in seen["environment"].values()


def test_what_was_sealed_before_is_what_is_told_afterwards(seen: dict[str, Any], tmp_path: Path) -> None:
    job = Job("through", "through-001", 7, False, tmp_path)
    prove_case(job)
    sealed = tmp_path / seal.TRUTHS / "through-001.json"
    assert seal.read_truth(sealed)["effects"][0]["form"] == SECRET
    again = done_before(job)
    assert again is not None
    assert again.seconds == 1.5
    sealed.write_text(sealed.read_text().replace("unknown", "friction.stribeck"))
    with pytest.raises(ProofError, match="seal"):
        done_before(job)


def test_plants_of_a_set_differ_and_follow_from_the_seed() -> None:
    seeds = {case.plant_seed(7, f"through-{k:03d}") for k in range(20)}
    assert len(seeds) == 20
    assert case.plant_seed(7, "through-004") == case.plant_seed(7, "through-004")
    assert plant_named("conceal=3") == "rh380n?conceal=3"


def test_noise_of_a_recording_the_twin_has_not_is_that_of_all_its_own() -> None:
    floor = {"a": {"motor_torque": 3.0}, "b": {"motor_torque": 4.0, "temperature": 0.02}}
    rows = case._of([{"id": "a"}, {"id": "c"}], floor)
    assert rows["a"] == {"motor_torque": 3.0}
    assert rows["c"]["motor_torque"] == pytest.approx(np.sqrt(12.5))


def _recording(path: Path, name: str, kind: str, torque: Any) -> Recording:
    size = torque.size
    data = {"time": np.arange(size) / 100.0, "motor_torque": torque}
    specs = {"time": ChannelSpec("time", "s"), "motor_torque": ChannelSpec("motor_torque", "N·m")}
    header = builders.header(name, sample_rate=100.0, kind=kind)
    path.mkdir(exist_ok=True)
    write_recording(
        path / f"{name}.h5", header, {n: (data[n], specs[n]) for n in data}, [Segment("steady", 0, size)], []
    )
    return Recording.open(path / f"{name}.h5")


def test_two_runs_are_compared_sample_by_sample_up_to_the_first_warm_up(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)

    def run(name: str, off: float) -> list[Recording]:
        kinds = [("a", "constant_velocity"), ("b", "heating"), ("c", "constant_velocity")]
        noise = [rng.normal(0.0, 0.1, 4000) + off * (number + 1) for number in range(3)]
        return [_recording(tmp_path / name, k, kind, n) for (k, kind), n in zip(kinds, noise, strict=True)]

    noise = {name: {"motor_torque": 0.1} for name in "abc"}
    plant, same, other = run("plant", 0.0), run("same", 0.0), run("other", 0.2)
    assert loop.apart(plant, same, noise)["motor_torque"] == pytest.approx(1.0, rel=0.05)
    assert loop.apart(plant, other, noise)["motor_torque"] == pytest.approx(np.sqrt(1.0 + 0.2**2 / 0.02), rel=0.05)
    # of another length is not of the same course
    assert loop.apart(plant[:1], [_recording(tmp_path / "short", "a", "constant_velocity", np.zeros(100))], noise) == {}


def test_a_model_is_asked_of_another_campaign_on_the_same_plant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ran: list[tuple[str, str, int, str]] = []

    def run_on(plant: str, folder: Path, seed: int, campaign: Path) -> None:
        ran.append((plant, folder.name, seed, campaign.name))
        _recording(folder, "a", "constant_velocity", np.full(400, 0.3))

    def predicted(content: Any, recordings: Any) -> Any:
        yield recordings[0], {"motor_torque": np.full(400, content["at"])}

    monkeypatch.setattr(loop, "run_on", run_on)
    monkeypatch.setattr(loop, "predictor", lambda: predicted)
    model = tmp_path / "model.json"
    model.write_text(json.dumps({"at": 0.1}))
    found = loop.closed("rh380n?conceal=5", 17, model, {"a": {"motor_torque": 0.2}}, lambda folder, given: "match")
    assert (found["residual"], found["verdict"]) == ({"motor_torque": pytest.approx(1.0)}, "match")
    assert found["played"] == {"motor_torque": 0.0}
    (plant, first, seed, campaign), (playing, second, _, _) = ran
    assert (plant, seed, campaign, first != second) == ("rh380n?conceal=5", 18, "again.toml", True)
    assert playing.endswith(".toml")
    assert loop.closed("p", 1, tmp_path / "none.json", {}, lambda *_: "")["why"]
