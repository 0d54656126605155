"""What a run does of what operators want: acts for another run or point are refused in one sentence."""

from typing import Any

import pytest

from bench.campaigns.operator.directions import Directions
from bench.service.process.obey import Obedience


class Reporter:
    def __init__(self) -> None:
        self.said: list[Any] = []

    def report_status(self, phase: str, label: str = "", **more: Any) -> None:
        self.said.append(phase)

    def pausing(self, asked: bool) -> None:
        self.said.append(("pausing", asked))

    def asked(self, wish: str, identity: str) -> None:
        self.said.append((wish, identity))

    def noticed(self, text: str) -> None:
        self.said.append(text)

    def points(self) -> dict[str, dict[str, Any]]:
        return {"aa": {"number": 1, "state": "done"}, "bb": {"number": 2, "state": "running"}}


class Run:
    def __init__(self) -> None:
        self.directions, self.reporter = Directions(), Reporter()
        self.obey = Obedience("run-1", self.directions, self.reporter)

    def __call__(self, **message: Any) -> Any:
        self.obey(message)
        return self.reporter.said[-1] if self.reporter.said else None


@pytest.mark.parametrize("act", ["pause", "go_on", "end", "skip", "repeat", "note"])
@pytest.mark.parametrize("meant", [{}, {"run": "run-2"}, {"run": None}, {"run": ["run-1"]}])
def test_what_is_meant_for_another_run_is_refused(act: str, meant: dict[str, Any]) -> None:
    run = Run()
    run.directions.pause()
    said = run(do=act, identity="bb", text="hello", **meant)
    assert "was meant for" in said
    assert "nothing was done" in said
    directions = run.directions
    assert (directions.stop_requested, directions.paused, directions.is_skipped("bb")) == (False, True, False)
    assert (directions.take_repeat(), directions.take_notes()) == (None, [])


def test_what_is_meant_for_this_run_is_done() -> None:
    run = Run()
    assert run(do="pause", run="run-1") == ("pausing", True)
    assert run(do="go_on", run="run-1") == ("pausing", False)
    assert run(do="skip", run="run-1", point="bb") == ("skip", "bb")
    assert run(do="repeat", run="run-1", identity="aa") == ("repeat", "aa")
    run(do="note", run="run-1", text="oil\u0000 changed")
    assert run.directions.take_notes() == ["oil changed"]
    assert run(do="end", run="run-1") == "stopping"
    assert run.directions.stop_requested


def test_a_point_of_another_run_or_that_is_over_is_refused() -> None:
    run = Run()
    assert "a point that this run does not have" in run(do="skip", run="run-1", point="cc")
    assert run(do="skip", run="run-1", point="aa") == "skip was meant for point 1, which is done: nothing was done"
    assert "500 are the most" in run(do="note", run="run-1", text="x" * 1_000_000)
    assert not run.directions.is_skipped("aa")


@pytest.mark.parametrize("meant", [{}, {"run": "run-2"}, {"run": "run-1"}])
def test_stop_is_never_refused(meant: dict[str, Any]) -> None:
    run = Run()
    assert run(do="stop", **meant) == "stopping"
    assert run.directions.stop_requested


@pytest.mark.parametrize("message", [{}, {"do": None}, {"do": "open the doors"}, {"do": {"a": 1}}])
def test_what_is_not_understood_is_no_order(message: dict[str, Any]) -> None:
    assert Run()(**message) is None
