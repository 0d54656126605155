"""As somebody who never saw it: plan a sweep, run it, find last month's run of the same gearbox, overlay both, read
what changed, take a figure away. On a phone and at 1280 × 800; every button is found by what is written on it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta

import pytest

from bench.recording import Setpoint
from tests.bench.recording.builders import write
from tests.browser.conftest import Browser, served_apart
from tests.browser.test_operator import TOO_WIDE, state

SCREENS = {"phone": (390, 844), "desk": (1280, 800)}
PHONE = 600
STOP = "const box = document.getElementById('stop').getBoundingClientRect(); return [box.top, box.bottom, box.right]"
SHEET_IN_SIGHT = """const box = document.getElementById('sheet').getBoundingClientRect();
const nav = document.querySelector('nav'), fixed = getComputedStyle(nav).position === 'fixed';
return box.top > document.querySelector('header').getBoundingClientRect().bottom
  && box.bottom <= (fixed ? nav.getBoundingClientRect().top : innerHeight)
  && box.left >= 0 && box.right <= innerWidth"""
CUT_OFF = "const box = document.getElementById(arguments[0]); return box.scrollWidth - box.clientWidth"
KEYS_CUT_OFF = """return [...document.querySelectorAll('#now .key')].filter(one => one.offsetParent)
  .map(one => one.scrollWidth - one.clientWidth).filter(more => more > 0)"""
PICTURE = """const done = arguments[0], texts = [], write = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
  texts.push(text);
  write.call(this, text, ...at);
};
URL.createObjectURL = blob => {
  createImageBitmap(blob).then(image => done([image.width, image.height, texts.join(' ')]));
  return '#';
};
[...document.querySelectorAll('#recording-acts button')].find(one => one.innerText === 'Picture').click();"""


@pytest.fixture
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder = tmp_path_factory.mktemp("newcomer")
    last_month = folder / "recordings" / "last-month"
    last_month.mkdir(parents=True)
    write(
        last_month / "0001-constant_velocity.h5",
        rows=6000,
        gearbox_serial="RH380-0417",
        campaign_id="last-month",
        started_at=datetime.now(UTC) - timedelta(days=31),
        setpoint=Setpoint(load_torque=500.0, velocity=math.radians(10.0), temperature=30.0),
    )
    with served_apart(folder) as url:
        yield url


@pytest.fixture(params=list(SCREENS))
def newcomer(request: pytest.FixtureRequest, new_browser: Callable[[str], Browser], address: str) -> Iterator[Browser]:
    page = new_browser(address)
    page.screen(*SCREENS[request.param])
    page.open()
    yield page
    page.driver.close()


def in_sight(page: Browser) -> None:
    """Nothing is wider than the screen, STOP is in reach, and a sheet is not hidden by the header."""
    assert page.driver.execute_script(TOO_WIDE) <= 0
    stop = page.driver.execute_script(STOP)
    assert 0 <= stop[0] < stop[1] <= page.driver.execute_script("return innerHeight")
    assert stop[2] <= page.driver.execute_script("return innerWidth")
    if page.find("#sheet").is_displayed():
        page.until(lambda: page.driver.execute_script(SHEET_IN_SIGHT))


def written(page: Browser, key: str, value: str) -> None:
    field = page.find(f"#plan-form [data-key={key}]")
    field.clear()
    field.send_keys(value)


def plan_and_run(page: Browser, address: str) -> None:
    page.click("#tabs button", "Plan")
    page.until(lambda: "2 points" in page.text("#plan-sum"))
    written(page, "load_torques", "500")
    written(page, "velocities", "10, 20")
    page.find("#plan-name").clear()
    page.find("#plan-name").send_keys("my-sweep")
    page.until(lambda: page.find("#plan-save").is_enabled() and "2 points" in page.text("#plan-sum"))
    in_sight(page)
    if page.driver.execute_script("return innerWidth") > PHONE:
        assert page.driver.execute_script(CUT_OFF, "plan-points") <= 0
    # why it cannot be started yet is written there
    assert page.text("#plan-hint") == "It can be started as soon as it is saved."
    assert not page.find("#plan-start").is_enabled()
    # time and energy come with the answer to the last change
    page.until(lambda: page.text("#plan-sum").count(" · ") >= 2)
    energy = page.text("#plan-sum").split(" · ")[2]
    page.click("button", "Save")
    page.find("#sheet-body input").send_keys("Eve")
    in_sight(page)
    page.click("#sheet-acts button", "Save")
    page.until(lambda: page.find("#plan-start").is_enabled())
    assert not page.find("#plan-hint").is_displayed()
    page.click("button", "Start it")
    page.find("#name").clear()
    page.find("#name").send_keys("Eve")
    page.click("#sheet-acts button", "Take the controls")
    page.until(lambda: page.text("#sheet-title") == "Start a campaign")
    page.click("#sheet .option", "As fast as the computer can")
    # the campaign that was planned is the one that is chosen
    page.until(lambda: "2 points" in page.text("#sheet-body"))
    assert energy.endswith("kWh")
    assert energy in page.text("#sheet-body")
    in_sight(page)
    page.click("#sheet-acts button", "Start")
    # what was started is seen
    page.until(lambda: page.attribute("#tabs [data-view=now]", "aria-selected") == "true")
    page.until(lambda: state(address, "runs")["runs"])
    page.until(lambda: state(address, "runs")["runs"][-1]["state"] == "ended")
    assert state(address, "runs")["runs"][-1]["end"]["kind"] == "finished"


def test_plan_run_find_overlay_read_and_export(newcomer: Browser, address: str, request: pytest.FixtureRequest) -> None:
    page = newcomer
    name = request.node.callspec.params["newcomer"]
    plan_and_run(page, address)
    assert page.driver.execute_script(KEYS_CUT_OFF) == []
    page.click("#tabs button", "Recordings")
    page.click("#folders tr[data-open]", "my-sweep")
    page.click("#folder-list tr[data-open]", "10.0 °/s")
    page.until(lambda: len(page.all("#recording-plots canvas")) >= 5)
    in_sight(page)
    page.click("#recording-acts button", "Lay another over it")
    page.until(lambda: "Choose the one to lay over" in page.text("#found-text"))
    page.until(lambda: page.text("#found-text").startswith("2 recordings in 2 campaigns"))
    in_sight(page)
    marked = [row.text for row in page.all("#found tr[data-open]") if "this is the one that is open" in row.text]
    assert len(marked) == 1
    assert "my-sweep" in marked[0]
    # the page scrolls to what was found: a click while it moves goes elsewhere
    page.still(page.find("#found"))
    page.click("#found tr[data-open]", "last-month")
    page.until(lambda: page.text("#changes h2").startswith("What changed: last-month"))
    page.driver.execute_script(
        "document.getElementById('changes').scrollIntoView({block: 'center', behavior: 'instant'})"
    )
    assert "µrad RMS" in page.text("#changes")
    in_sight(page)
    page.shot(f"operator-changes-{name}")
    width, height, texts = page.driver.execute_async_script(PICTURE)
    assert width > 300
    assert height > 600
    # the picture says of what it is, and which curve is whose
    assert "0001-constant_velocity: 500 N·m, 10.0 °/s" in texts
    assert "over 0001-constant_velocity of my-sweep-" in texts
    assert "last-month" in texts
    assert "mean of 0001-constant_velocity" in texts
    assert "the other" in texts
    assert [line for line in page.problems() if "/api/plan" not in line] == []
