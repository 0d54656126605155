"""What a folder of recordings says of its points, and what is said of a service in which nothing runs."""

import json
from pathlib import Path

import pytest

from bench.campaigns import load_campaign
from bench.campaigns.records.journal import Journal
from bench.campaigns.taken import Status, Taken
from bench.configuration import load_bench
from bench.service.data.recordings import folders
from tests.bench.service.conftest import Client


def take(point: str, number: int, status: Status, complete: bool | None) -> Taken:
    name = f"{point}-{number}"
    return Taken(name, f"{name}.h5", "reversal", name, {}, point, number, status, complete=complete)


@pytest.mark.parametrize(
    ("takes", "said"),
    [
        ([take("a", 1, Status.DONE, True), take("b", 1, Status.FAILED, False)], (1, 0, 1)),
        ([take("a", 1, Status.FAILED, True)], (0, 1, 0)),
        # stopped, and measured later
        ([take("a", 1, Status.FAILED, False), take("a", 2, Status.DONE, True)], (1, 0, 0)),
        ([take("a", 1, Status.FAILED, True), take("a", 2, Status.FAILED, False)], (0, 0, 1)),
        # of a journal that does not know
        ([take("a", 1, Status.FAILED, None)], (0, 1, 0)),
    ],
)
def test_a_point_that_was_stopped_is_cut_short_not_failed(
    tmp_path: Path, takes: list[Taken], said: tuple[int, int, int]
) -> None:
    folder = tmp_path / "spring"
    folder.mkdir()
    with Journal(folder, load_campaign("quick"), load_bench("rh380n")) as journal:
        for one in takes:
            journal.begin(one)
            journal.end(one)
    (entry,) = folders(tmp_path)
    assert (entry["done"], entry["failed"], entry["cut_short"]) == said


def test_a_take_of_an_earlier_journal_is_read() -> None:
    old = take("a", 1, Status.FAILED, False).as_dict()
    del old["complete"]
    assert Taken.from_dict(json.loads(json.dumps(old))).complete is None


def test_nothing_is_heard_where_nothing_runs(client: Client) -> None:
    assert client.get("health") == {"alive": True, "heard_s": None}
    client.take()
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "running")
    assert client.get("health")["heard_s"] >= 0.0
    client.launcher.processes[0].kill()
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    assert client.get("health")["heard_s"] is None
