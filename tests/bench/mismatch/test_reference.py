"""The simulation that recordings are compared with when none is given: of the gearbox that was recorded."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from bench.mismatch.given import Given, says_waves
from bench.mismatch.reference import open_reference
from bench.recording.header import Gearbox
from bench.simulation.model import Simulation
from bench.simulation.orders import nominal_orders, orders_in_doubt


@dataclass
class Recorded:
    """What is asked of a folder's data."""

    gearbox: Gearbox
    simulated: frozenset[str] = frozenset()
    follows_waves: bool = True

    @property
    def folder(self) -> Any:
        """How its motion is read."""
        return SimpleNamespace(manner=SimpleNamespace(follows_waves=self.follows_waves))


def test_its_orders_are_those_of_the_recorded_teeth(tmp_path: Path) -> None:
    data = cast(Any, Recorded(Gearbox(ratio=120.0, z1=18, z2=63, z3=33, z4=34)))
    given = open_reference(None, tmp_path).given(data)
    assert given.gearbox.z4 == 34
    orders = set(Given.of(given).orders)
    assert orders == {*nominal_orders(given.gearbox), *orders_in_doubt(given.gearbox)}
    assert orders != set(Given.of(Simulation.nominal()).orders)


def test_a_file_keeps_its_own(tmp_path: Path) -> None:
    file = tmp_path / "model.json"
    Simulation.nominal().save(file)
    data = cast(Any, Recorded(Gearbox(ratio=120.0, z1=18, z2=63, z3=33, z4=34)))
    assert open_reference(file, tmp_path).given(data).gearbox.ratio == 185.0


def test_what_the_recordings_say_of_waves_stands_in_the_simulation(tmp_path: Path) -> None:
    file = tmp_path / "model.json"
    Simulation.nominal().save(file)
    for simulation in (None, file):
        for follows in (True, False):
            data = cast(Any, Recorded(Gearbox(120.0, 18, 63, 33, 34), follows_waves=follows))
            reference = open_reference(simulation, tmp_path)
            assert reference.waves is None
            given = reference.given(data)
            assert says_waves(given) is follows
    given.save(file)
    assert open_reference(file, tmp_path).waves is False
