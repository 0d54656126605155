"""The example files do what the pages say."""

from __future__ import annotations

import runpy
import tomllib
from pathlib import Path

import pytest

from bench.campaigns.planning.facts import facts
from bench.configuration import load_bench
from bench.protocols import Request, Segment, Sequence
from drivers.errors import DriverError, SensorError
from tests.docs.commands import ROOT

EXAMPLES = ROOT / "docs" / "examples"


def test_the_example_sequence_is_one_and_ends_without_load() -> None:
    cls = runpy.run_path(str(EXAMPLES / "lost_motion.py"))["LostMotion"]
    sequence = cls(loops=3, rate=25.0)
    assert isinstance(sequence, Sequence)
    bench = facts(load_bench("rh380n").configuration)
    points = sequence.points(Request("lost_motion", load_torques=(50.0, 200.0), temperatures=(None, 40.0), repeats=2))
    assert len(points) == 8
    phases = sequence.phases(points[0], bench)
    levels = [phase.load_torque for phase in phases]
    assert levels == [50.0, *(3 * [-50.0, 50.0]), 0.0]
    assert sum(phase.duration_s for phase in phases) == pytest.approx((1 + 3 * 4 + 1) * 50.0 / 25.0)
    assert {phase.segment for phase in phases} == {Segment.STEADY, Segment.RAMP_DOWN}
    assert all(phase.velocity == 0.0 for phase in phases)


def test_the_entry_point_on_the_page_names_the_class() -> None:
    page = (ROOT / "docs" / "extending.md").read_text("utf-8")
    table = tomllib.loads(page.split("```toml\n")[1].split("```")[0])
    (target,) = table["project"]["entry-points"]["bench.sequences"].values()
    assert target.split(":")[1] in runpy.run_path(str(EXAMPLES / "lost_motion.py"))


def test_the_example_driver_measures_or_says_why_not(tmp_path: Path) -> None:
    make = runpy.run_path(str(EXAMPLES / "file_thermometer.py"))["file_thermometer"]
    file = tmp_path / "temperature.txt"
    thermometer = make("temperature", {"path": str(file)})
    with pytest.raises(SensorError, match="is its writer running"):
        thermometer.measure()
    file.write_text("31.5\n")
    assert thermometer.measure().temperature_c == 31.5
    file.write_text("warm\n")
    with pytest.raises(SensorError, match="holds no temperature"):
        thermometer.measure()
    thermometer.close()
    with pytest.raises(DriverError, match="exactly path"):
        make("temperature", {"file": str(file)})
