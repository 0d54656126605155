"""Beside the twin's alarm, in a real browser: what changed between the recordings before it and those since."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.bench.recording.builders import write
from tests.browser.conftest import AN_ANALYSIS, Browser, page_over

SINCE = "0002-x_y"
ALARM = {
    "number": 1, "at": "2026-03-02T10:00:00+00:00", "cause": "TWIN", "text": f"the model no longer holds since {SINCE}",
    "what_to_do": "Compare before and since.", "point": SINCE, "folder": "again",
}  # fmt: skip


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of two recordings, and an alarm of the twin that stands since the second."""
    root = tmp_path_factory.mktemp("before-since") / "recordings"
    (root / "again").mkdir(parents=True)
    for day, name in ((1, "0001-x_y"), (2, SINCE)):
        write(root / "again" / f"{name}.h5", rows=100, started_at=datetime(2026, 3, day, 9, tzinfo=UTC))
    (root / ".service").mkdir()
    (root / ".service" / "alarms.json").write_text(json.dumps([ALARM]), "utf-8")
    return root


@pytest.fixture(scope="module")
def page(new_browser: Callable[[str], Browser], root: Path) -> Iterator[Browser]:
    with page_over(root.parent, new_browser) as browser:
        yield browser


def test_before_and_since_is_one_click_beside_the_alarm(page: Browser, root: Path) -> None:
    page.click("#alarms button", "Compare before and since")
    page.until(lambda: "Before and since: again" in page.text("#analyses"))
    card = "#analyses .card:first-child"
    # the recordings are hardly enough for an identification: the answer says so, of the parts that were asked for
    page.until(lambda: f"1 recordings before {SINCE} and 1 since" in page.text(card))
    page.until(lambda: "✓ done" in page.text(card), deadlines=AN_ANALYSIS)
    (work,) = root.glob(".service/analyses/*/work.json")
    assert json.loads(work.read_text("utf-8"))["asked"] == {"since": SINCE}


def test_its_report_is_read_on_the_page_and_the_alarm_stays_until_it_is_acknowledged(page: Browser) -> None:
    page.click("#analyses .card:first-child button", "Read the report")
    page.until(lambda: "Before and since: again" in page.text("#report-title"))
    assert "the model no longer holds" in page.text("#alarms")
    assert [b.text for b in page.all("#alarms button")] == ["Compare before and since", "Acknowledge"]
    assert page.problems() == []
