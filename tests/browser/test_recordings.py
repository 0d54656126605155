"""Finding recordings and looking into them, in a real browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import UTC, datetime

import pytest
from selenium.webdriver import ActionChains

from tests.bench.recording.builders import write
from tests.browser.conftest import CENTRE, Browser, page_over


@pytest.fixture(scope="module")
def page(new_browser: Callable[[str], Browser], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The page over two campaigns of two recordings each."""
    root = tmp_path_factory.mktemp("recordings")
    for folder, month in (("spring", 3), ("autumn", 9)):
        (root / "recordings" / folder).mkdir(parents=True)
        for number in (1, 2):
            write(
                root / "recordings" / folder / f"000{number}-constant_velocity.h5",
                rows=6000,
                gearbox_serial=("RH-0417", "RH-0999")[number - 1],
                started_at=datetime(2026, month, number, 9, tzinfo=UTC),
                campaign_id=folder,
            )
    with page_over(root, new_browser) as browser:
        yield browser


def zoomed_values_and_files(page: Browser) -> None:
    """Look into a stretch, choose channels, and take what is shown away."""
    over = page.find("[data-channel=load_torque] .u-over")
    page.driver.execute_script(CENTRE, over)
    page.still(over)
    mouse = ActionChains(page.driver, duration=50)
    mouse.move_to_element_with_offset(over, -60, 0).click_and_hold().move_by_offset(40, 0).release().perform()
    # every channel shows the stretch, asked for again in its own detail
    page.until(lambda: len(page.all("#recording-plots .zoomed")) == len(page.all("#channels button")))
    mouse.double_click(over).perform()
    page.until(lambda: not page.all("#recording-plots .zoomed"))
    page.click("#channels button", "Motor torque")
    page.until(lambda: not page.all("[data-channel=motor_torque]"))
    page.click("#channels button", "Motor torque")
    page.until(lambda: page.all("[data-channel=motor_torque]"))
    text = page.driver.execute_async_script(SAVED_VALUES)
    assert text.startswith("plot,series,x,value\n")
    assert '"mean"' in text
    assert text.count("\n") > 100
    size = page.driver.execute_async_script(SAVED_PICTURE)
    assert size[0] > 500
    assert size[1] > 300


SAVED_VALUES = """const done = arguments[0];
URL.createObjectURL = blob => { blob.text().then(done); return '#'; };
[...document.querySelectorAll('#recording-acts button')].find(one => one.innerText === 'Values').click();"""
SAVED_PICTURE = """const done = arguments[0];
URL.createObjectURL = blob => { createImageBitmap(blob).then(image => done([image.width, image.height])); return '#'; };
[...document.querySelectorAll('#recording-acts button')].find(one => one.innerText === 'Picture').click();"""


def test_a_recording_is_found_again_noted_and_another_laid_over_it(page: Browser) -> None:
    page.view("recordings")
    page.until(lambda: "2 campaigns" in page.text("#found-text"))
    page.find("#q-words").send_keys("topped up")
    page.click("#search summary")
    page.find("#q-load_torque").send_keys("500")
    page.find("#q-gearbox").send_keys("0417")
    page.until(lambda: "2 recordings in 2 campaigns" in page.text("#found-text"))
    page.click("#found tbody tr")
    page.until(lambda: page.all("[data-channel=load_torque] canvas"))
    page.until(lambda: page.all("#recording-plots .revolution h2"))
    page.until(lambda: len(page.all("#recording-plots canvas")) >= 7)
    zoomed_values_and_files(page)
    page.click("#recording-acts button", "Comment")
    fields = page.all("#sheet-body input")
    fields[0].send_keys("louder than in spring")
    fields[1].send_keys("Ann")
    page.click("#sheet-acts button", "Write it down")
    page.until(lambda: "louder than in spring" in page.text("#recording-notes"))
    page.click("#recording-acts button", "Lay another over it")
    # offered are those of this gearbox at this set point
    page.until(lambda: "Choose the one to lay over" in page.text("#found-text"))
    assert page.find("#q-gearbox").get_attribute("value") == "RH-0417"
    page.until(lambda: len(page.all("#found tbody tr")) == 2)
    page.click("#found tbody tr:nth-child(2)")
    page.until(lambda: ", over 0" in page.text("#recording-title"))
    # the earlier one stands first, whichever was opened first
    page.until(lambda: page.text("#changes h2").startswith("What changed: spring, 2026-03-01"))
    assert "→ autumn, 2026-09-01" in page.text("#changes h2")
    assert "µrad RMS" in page.text("#changes p")
    assert "lubricant" in page.text("#changes")
    # the same numbers were written into both
    assert "(less than 0.1 % apart)" in page.text("#changes")
    page.until(lambda: len(page.all("[data-channel=load_torque] .u-legend .u-series")) == 5)
    page.until(lambda: "below it" in page.text("#recording-plots .revolution > h2"))
    page.size(1280, 1500)
    page.driver.execute_script("document.getElementById('recording-card').scrollIntoView({behavior: 'instant'})")
    page.shot("operator-overlay")
    page.find("#q-words").clear()
    page.find("#q-words").send_keys("louder spring")
    page.until(lambda: page.text("#found-text").startswith("1 recording in 1"))
    page.driver.execute_script("scrollTo({top: 0, behavior: 'instant'})")
    page.shot("operator-search")
    page.size(1280, 1100)
    assert page.problems() == []


GAPS = """const done = arguments[0];
import('/static/buffers.js').then(({ Buffers }) => {
  const buffers = new Buffers(), at = [0, 0.2, 0.4, 30, 30.2];
  for (const start of at) buffers.add({ start, end: start + 0.2, values: { load_torque: [0, 1, 0.5, 1] } });
  done(buffers.window(60, ['load_torque']).load_torque[2]);
});"""


def test_nothing_is_drawn_where_nothing_was_read(page: Browser) -> None:
    assert page.driver.execute_async_script(GAPS) == [0.5, 0.5, 0.5, None, 0.5, 0.5]
