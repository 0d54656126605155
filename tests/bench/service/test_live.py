"""Live values: buckets that lose no extreme, memory that does not grow, the revolution bin by bin, a deaf listener."""

from __future__ import annotations

import asyncio
import itertools
import json
import socket
import threading
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.cycle.channels import Scaling
from bench.protocols import Segment
from bench.recording import ChannelSpec
from bench.service.analyses.overlay import Overlay
from bench.service.process.covered import Covered
from bench.service.process.lines import LineServer
from bench.service.process.revolution import BINS, Revolution
from bench.service.process.tap import LiveTap
from bench.service.runs.history import COARSE, COARSE_S, FINE, History, merge
from bench.service.runs.stream import Stream
from bench.simulation import FourierSet, Simulation, TransmissionErrorModel, basis

RATIO = 100.0
NAMES = ("motor_angle", "load_angle", "motor_velocity", "load_torque", "temperature")


def bucket(start: float, low: float, high: float, seconds: float = 0.1) -> dict[str, Any]:
    values = {"load_torque": [low, high, (low + high) / 2, high]}
    return {"type": "live", "start": start, "end": start + seconds, "values": values}


def test_the_history_of_twelve_hours_is_bounded_and_keeps_every_extreme() -> None:
    history = History()
    count = 12 * 18000
    for number in range(count):
        spike = 1000.0 if number == 5 * 18000 else 1.0
        history.add(bucket(0.2 * number, -spike, spike, 0.2))
    fine, coarse = history.fine(), history.coarse()
    assert len(fine) == FINE
    assert len(coarse) <= COARSE + 1
    assert coarse[-1]["end"] - coarse[0]["start"] > 11.5 * 3600
    assert max(part["values"]["load_torque"][1] for part in coarse) == 1000.0
    assert min(part["values"]["load_torque"][0] for part in coarse) == -1000.0
    assert all(part["end"] - part["start"] < 2 * COARSE_S for part in coarse)


@given(st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(0.0, 1e3), st.floats(0.01, 10.0)), min_size=1, max_size=20))
def test_merging_keeps_extremes_and_the_mean_by_time(parts: list[tuple[float, float, float]]) -> None:
    buckets, at = [], 0.0
    for low, spread, seconds in parts:
        buckets.append(bucket(at, low, low + spread, seconds))
        at += seconds
    low, high, mean, last = merge(buckets)["values"]["load_torque"]
    assert low == min(part[0] for part in parts)
    assert high == max(part[0] + part[1] for part in parts)
    total = sum(part[2] for part in parts)
    weighted = sum((part[0] + part[1] / 2) * part[2] for part in parts) / total
    assert mean == pytest.approx(weighted, abs=1e-6 * (1.0 + abs(weighted)) + 1e-6)
    assert last == parts[-1][0] + parts[-1][1]


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("block", [4, 1000, 50_000])
def test_the_spectrum_of_a_revolution_is_that_of_the_error(direction: float, block: int) -> None:
    theta = direction * np.linspace(0.3, 0.3 + 2.2 * np.pi, 50_000)
    error = 30e-6 * np.sin(46 * theta + 1.0) + 5e-6 * np.cos(4 * theta) + 1e-3
    revolution = Revolution()
    for start in range(0, theta.size, block):
        revolution.add(theta[start : start + block], error[start : start + block])
    found = revolution.spectrum()
    assert found is not None
    assert revolution.share == 1.0
    assert found.amplitude[45] == pytest.approx(30e-6, rel=0.01)
    assert found.amplitude[3] == pytest.approx(5e-6, rel=0.01)
    assert np.delete(found.amplitude, [3, 45]).max() < 0.3e-6
    assert found.rms == pytest.approx(np.sqrt((30e-6**2 + 5e-6**2) / 2), rel=0.01)


def test_no_spectrum_before_the_revolution_is_whole_and_the_last_pass_counts() -> None:
    revolution = Revolution()
    part = np.linspace(0.0, 1.9 * np.pi, 20_000)
    revolution.add(part, np.zeros_like(part))
    assert revolution.spectrum() is None
    assert 0.9 < revolution.share < 0.96
    again = np.linspace(1.9 * np.pi, 4.0 * np.pi, 20_000)
    revolution.add(again, 1e-5 * np.sin(3 * again))
    found = revolution.spectrum()
    assert found is not None
    assert found.amplitude[2] == pytest.approx(1e-5, rel=0.01)
    revolution.clear()
    assert revolution.share == 0.0


def simulation_file(path: Path, **series: Any) -> Path:
    """A model of one order, 12 µrad at order 46, in the positive direction only."""
    amplitude = np.zeros((1, 10))
    amplitude[0] = 12e-6 * basis(0.0, 0.0, 0.0)
    fourier = FourierSet(np.array([46.0]), amplitude, np.zeros((1, 10)), np.zeros(10), **series)
    Simulation.nominal().with_transmission_error(TransmissionErrorModel(fourier, None)).save(path)
    return path


def measured(velocity: float = 0.1) -> dict[str, Any]:
    curve = 12e-6 * np.sin(46 * (np.arange(512) + 0.5) * 2 * np.pi / 512)
    curve[:128] += 20e-6
    known = {"torque": 100.0, "velocity": velocity, "temperature": 30.0}
    return {"type": "spectrum", "amplitude": [0.0], "curve": curve.tolist(), **known}


def test_the_model_is_drawn_as_it_was_made(tmp_path: Path) -> None:
    overlay = Overlay(lambda _: None)
    assert overlay.add(measured()) == measured()
    overlay.choose(simulation_file(tmp_path / "model.json"))
    drawn = overlay.add(measured())
    assert int(np.argmax(drawn["model"])) + 1 == 46
    assert drawn["model"][45] == pytest.approx(12e-6, rel=1e-3)
    assert np.max(drawn["model_curve"]) == pytest.approx(12e-6, rel=0.05)
    assert "model_band" not in drawn
    assert "no covariance" in drawn["model_why"]
    other_way = overlay.add(measured(-0.1))
    assert "model" not in other_way
    assert "never fitted in this direction" in other_way["model_why"]
    without = overlay.add({**measured(), "temperature": None})
    assert "not known here" in without["model_why"]


def test_the_band_is_drawn_and_what_lies_in_it_counted(tmp_path: Path) -> None:
    joint = np.zeros((1, 20, 20))
    joint[0] = 1e-12 * np.outer(x := np.concatenate([basis(0.0, 0.0, 0.0), np.zeros(10)]), x)
    path = simulation_file(tmp_path / "model.json", covariance=joint)
    content = json.loads(path.read_text("utf-8"))
    (term,) = (one for one in content["terms"] if one["effect"] == "te.fourier")
    term["left_rmse"] = {"positive": 3e-6}
    path.write_text(json.dumps(content), "utf-8")
    overlay = Overlay(lambda _: None)
    overlay.choose(path)
    drawn = overlay.add(measured())
    least, most = np.min(drawn["model_band"]), np.max(drawn["model_band"])
    assert least == pytest.approx(1.96 * 3e-6, rel=0.01)
    assert most == pytest.approx(1.96 * np.hypot(3e-6, 1e-6), rel=0.01)
    # a quarter of the revolution is 20 µrad off
    assert drawn["model_inside"] == pytest.approx(0.75)
    assert (drawn["model_left"], drawn["model_why"]) == (3e-6, "")


def test_the_model_that_watches_a_run_is_drawn_until_another_is_chosen(tmp_path: Path) -> None:
    overlay = Overlay(lambda _: None)
    mine, twin = simulation_file(tmp_path / "mine.json"), simulation_file(tmp_path / "twin.json")
    overlay.choose(mine)
    overlay.watch(twin)
    assert overlay.path == twin
    overlay.watch(None)
    assert overlay.path == mine
    overlay.watch(twin)
    overlay.choose(None)
    assert overlay.path is None
    assert overlay.add(measured()) == measured()


def test_how_far_a_run_has_moved() -> None:
    covered = Covered()
    covered.begin(100.0)
    covered.add(np.linspace(0.0, 1.0, 50), 101.0)
    turned = covered.add(np.linspace(1.0, 0.4, 50), 102.0)
    way = {"travel": 1.6, "reversal_travel": 0.6, "reversal_time": 0.0, "reversed_before": 1.0}
    assert turned == pytest.approx({"time": 2.0, "elapsed": 2.0, **way})
    covered.begin(110.0)
    again = covered.add(np.array([7.0, 7.5]), 111.0)
    way = {"travel": 2.1, "reversal_travel": 0.5, "reversal_time": 1.0, "reversed_before": 0.0}
    assert again == pytest.approx({"time": 11.0, "elapsed": 1.0, **way})


def scaling() -> Scaling:
    specs = [ChannelSpec.of(name, scale=1e-3) for name in NAMES]
    return Scaling({spec.name: spec for spec in [ChannelSpec.of("time", scale=5e-4), *specs]})


def rows(first: int, n: int) -> dict[str, np.ndarray]:
    cycle = np.arange(first, first + n, dtype=np.int64)
    torque = np.zeros(n, np.int16)
    torque[n // 2] = 7000 if first == 3000 else 5
    return {
        "cycle": cycle,
        "motor_angle": cycle * 1000,
        "load_angle": cycle * 10,
        "motor_velocity": np.full(n, 2000, np.int32),
        "load_torque": torque,
        "temperature": np.full(n, 25_000, np.int16),
    }


def test_the_tap_loses_no_spike_and_no_time() -> None:
    messages: list[dict[str, Any]] = []
    tap = LiveTap(messages.append, RATIO)
    began = datetime(2026, 11, 21, 12, tzinfo=UTC)
    tap.begin(scaling(), began, "constant_velocity")
    tap.segment(Segment.STEADY)
    for block in range(10):
        tap.rows(rows(1000 * block, 1000))
    tap.close()
    live = [message for message in messages if message["type"] == "live"]
    assert live[0]["start"] == began.timestamp()
    assert live[-1]["end"] == pytest.approx(began.timestamp() + 5.0)
    for before, after in itertools.pairwise(live):
        assert after["start"] == pytest.approx(before["end"])
    assert max(message["values"]["load_torque"][1] for message in live) == pytest.approx(7.0)
    assert all(message["values"]["temperature"][2] == pytest.approx(25.0) for message in live)
    spectra = [message for message in messages if message["type"] == "spectrum"]
    assert spectra
    assert spectra[-1]["share"] > 0.9
    assert len(spectra[-1]["amplitude"]) == 320
    assert json.dumps(messages, allow_nan=False)
    assert BINS == 2048


def test_a_listener_that_does_not_read_holds_up_nobody(tmp_path: Path) -> None:
    heard: list[dict[str, Any]] = []
    server = LineServer(tmp_path / "s", lambda: [{"type": "status", "phase": "free"}], heard.append)
    deaf, good = (socket.socket(socket.AF_UNIX) for _ in range(2))
    deaf.connect(str(tmp_path / "s"))
    good.connect(str(tmp_path / "s"))
    lines = good.makefile("r")
    assert json.loads(lines.readline())["phase"] == "free"
    received: list[str] = []
    reader = threading.Thread(target=lambda: received.extend(lines), daemon=True)
    reader.start()
    good.sendall(b'{"do": "pause"}\nnot json\n[1]\n{"do": "stop"}\n')
    start = time.monotonic()
    for number in range(3000):
        server.send({"type": "live", "text": "x" * 2000})
        if number % 10 == 0:
            server.send({"type": "point", "number": number})
            # give the good one the processor now and then
            time.sleep(0.001)
    assert time.monotonic() - start < 30.0
    server.close(wait_s=2.0)
    reader.join(20.0)
    assert not reader.is_alive()
    numbers = [json.loads(line)["number"] for line in received if '"point"' in line]
    assert numbers == list(range(0, 3000, 10))
    assert [message["do"] for message in heard] == ["pause", "stop"]
    for end in (deaf, good):
        end.close()
    lines.close()


def test_a_page_that_does_not_read_loses_live_values_first_and_is_then_let_go() -> None:
    async def scene() -> tuple[list[str], int]:
        stream = Stream()
        events = stream.events([{"type": "status"}])
        first = [await anext(events)]
        assert stream.pages == 1
        for number in range(150):
            stream.publish({"type": "live", "number": number})
        for number in range(320):
            stream.publish({"type": "point", "number": number})
        rest = [text async for text in events]
        return first + rest, stream.pages

    texts, pages = asyncio.run(scene())
    assert pages == 0
    assert sum("event: live" in text for text in texts) == 100
    assert sum("event: point" in text for text in texts) == 300
