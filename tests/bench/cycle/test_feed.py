"""What becomes of cycles on their way into a recording."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from bench.cycle.decode import Decoded
from bench.cycle.feed import hand_on


class Sink:
    def __init__(self) -> None:
        self.cycles: list[int] = []
        self.events: list[str] = []

    def segment(self, segment: object) -> None:
        raise AssertionError("no segment begins here")

    def rows(self, raw: dict[str, Any]) -> None:
        self.cycles += raw["cycle"].tolist()

    def event(self, level: str, text: str) -> None:
        self.events.append(f"{level}: {text}")


def decoded(good: list[bool], late_s: list[float] | None) -> Decoded:
    inputs = SimpleNamespace(good=np.array(good))
    late = None if late_s is None else np.array(late_s)
    return Decoded({"cycle": np.arange(len(good))}, cast(Any, inputs), None, late)


def test_a_lost_cycle_leaves_no_row() -> None:
    sink = Sink()
    hand_on(decoded([True, False, True, True], None), 0, 3, sink)
    assert sink.cycles == [0, 2]
    assert sink.events == []


def test_cycles_made_up_for_are_rows_and_said() -> None:
    sink = Sink()
    hand_on(decoded([True] * 5, [0.0, 0.0026, 0.0022, 0.0, 0.0]), 0, 5, sink)
    hand_on(decoded([True] * 5, [0.0, 0.0026, 0.0022, 0.0, 0.0]), 3, 5, sink)
    assert sink.cycles == [0, 1, 2, 3, 4, 3, 4]
    assert sink.events == ["info: 2 cycles began up to 2.6 ms late and were made up for"]
