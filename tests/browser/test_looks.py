"""How the page is for everybody: contrast, names for a screen reader, keys, small screens, trends, record book."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
from selenium.webdriver import Keys

from bench.trend import kept
from tests.bench.recording.builders import write
from tests.bench.trend.conftest import identified
from tests.browser.conftest import REQUIRE, Browser, page_over

AXE = Path(__file__).parent / "node_modules" / "axe-core" / "axe.min.js"
VIEWS = ("now", "campaign", "plan", "recordings", "analysis", "trend", "place")


def campaigns(root: Path) -> None:
    """Five campaigns of one gearbox, identified; in the last, friction is a tenth more."""
    for month, friction in ((1, 0.6), (3, 0.601), (5, 0.599), (7, 0.6), (9, 0.66)):
        folder = root / f"month-{month}"
        folder.mkdir(parents=True)
        begun = datetime(2026, month, 5, 8, tzinfo=UTC)
        write(folder / "r001.h5", rows=60, gearbox_serial="RH-0417", started_at=begun, campaign_id=folder.name)
        kept.store(identified(folder.name, friction), folder, kept.stamp_of(folder))


@pytest.fixture(scope="module")
def page(new_browser: Callable[[str], Browser], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    root = tmp_path_factory.mktemp("looks")
    campaigns(root / "recordings")
    with page_over(root, new_browser) as browser:
        yield browser
        browser.driver.close()


CONTRAST = r"""
const channel = value => value <= 0.03928 * 255 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4;
const luminance = text => {
  const [r, g, b] = text.match(/[\d.]+/g).slice(0, 3).map(channel);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const ground = element => {
  for (let one = element; one; one = one.parentElement) {
    const colour = getComputedStyle(one).backgroundColor;
    if (!/^rgba\(.*, 0\)$|transparent/.test(colour)) return colour;
  }
  return 'rgb(255, 255, 255)';
};
const seen = one => one.offsetParent && !one.closest(':disabled, canvas, .uplot, svg')
  && [...one.childNodes].some(node => node.nodeType === 3 && node.data.trim());
return [...document.querySelectorAll('body *')].filter(seen).map(one => {
  const style = getComputedStyle(one), two = [luminance(style.color), luminance(ground(one))].sort((a, b) => b - a);
  return [(two[0] + 0.05) / (two[1] + 0.05), parseFloat(style.fontSize) >= 24 ? 3 : 4.5, one.innerText.slice(0, 30)];
}).filter(([ratio, least]) => ratio < least);"""
"""Texts below the contrast of WCAG 2.2 AA (1.4.3): ratio, least ratio, text."""
NAMELESS = """
return [...document.querySelectorAll('button, input, select, textarea, [role=img], [role=radiogroup]')]
  .filter(one => one.offsetParent || one.ownerSVGElement)
  .filter(one => !(one.innerText?.trim() || one.ariaLabel || one.getAttribute('aria-label') || one.title
    || one.labels?.length || one.getAttribute('aria-labelledby')))
  .map(one => one.outerHTML.slice(0, 80));"""
"""What can be used and has no name for a screen reader (WCAG 2.2, 4.1.2)."""
WIDER = "return document.documentElement.scrollWidth - document.documentElement.clientWidth"


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_text_has_the_contrast_of_wcag_aa_and_every_control_a_name(page: Browser, theme: str) -> None:
    page.view("place")
    page.click("#themes button", theme)
    for name in VIEWS:
        page.view(name)
        assert page.driver.execute_script(CONTRAST) == [], name
        assert page.driver.execute_script(NAMELESS) == [], name
    page.view("place")
    page.click("#themes button", "light")


@pytest.fixture(scope="module")
def axe() -> str:
    """The source of axe-core; without it the test skips with the command that installs it."""
    if not AXE.exists():
        why = "axe-core is not installed: npm install --no-package-lock --prefix tests/browser"
        if os.environ.get(REQUIRE) == "1":
            pytest.fail(f"{why} ({REQUIRE}=1)")
        pytest.skip(why)
    return AXE.read_text("utf-8")


RUN_AXE = """const done = arguments[arguments.length - 1];
const tags = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'];
const told = node => `${node.html.slice(0, 160)} | ${node.any.map(check => check.message).join('; ')}`;
axe.run(document, { runOnly: tags, resultTypes: ['violations'] }).then(
  found => done(found.violations.map(one => [one.id, one.help, one.nodes.slice(0, 4).map(told)])));"""


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1280])
def test_axe_finds_nothing_on_any_page(page: Browser, axe: str, theme: str, width: int) -> None:
    page.view("place")
    page.click("#themes button", theme)
    page.screen(width, 800)
    page.driver.execute_script(axe)
    found = {}
    for name in VIEWS:
        page.view(name)
        if violations := page.driver.execute_async_script(RUN_AXE):
            found[name] = violations
    page.find("body").send_keys("?")
    page.until(lambda: page.find("#sheet").is_displayed())
    if violations := page.driver.execute_async_script(RUN_AXE):
        found["sheet"] = violations
    page.find("body").send_keys(Keys.ESCAPE)
    page.screen()
    page.view("place")
    page.click("#themes button", "light")
    assert not found, "\n".join(f"{name}: {one}" for name, many in found.items() for one in many)


@pytest.mark.parametrize("width", [360, 390, 500])
def test_no_page_is_wider_than_a_phone(page: Browser, width: int) -> None:
    page.screen(width, 844)
    for name in VIEWS:
        page.view(name)
        assert page.driver.execute_script("return innerWidth") == width
        assert page.driver.execute_script(WIDER) <= 0, name
    page.screen()


BOX = (
    "const box = document.querySelector(arguments[0]).getBoundingClientRect(); return [box.top, box.bottom, box.right]"
)


def test_on_a_phone_stop_and_a_value_come_before_anything_else(page: Browser) -> None:
    page.screen(390, 844)
    page.view("now")
    page.driver.execute_script("scrollTo({top: 0, behavior: 'instant'})")
    page.until(lambda: "°C" in page.text("#v-temperature"))
    page.shot("operator-phone")
    stop, value = page.driver.execute_script(BOX, "#stop"), page.driver.execute_script(BOX, "#v-speed")
    assert 0 <= stop[0] < stop[1] <= 844
    assert stop[2] <= 390
    # without scrolling; the pages' tabs and everything that is only done come later
    assert value[1] <= 844
    for later in ("#tabs", "#acts", "#plot-speed"):
        assert page.driver.execute_script(BOX, later)[0] >= value[1], later
    page.screen()


def test_plots_are_in_sight_at_1280_by_800(page: Browser) -> None:
    page.screen(1280, 800)
    page.view("now")
    page.until(lambda: "°C" in page.text("#v-temperature"))
    page.driver.execute_script("scrollTo({top: 0, behavior: 'instant'})")
    page.shot("operator-small")
    for plot in ("#plot-speed", "#plot-torque", "#plot-temperature", "#plot-spectrum", "#plot-curve"):
        assert page.driver.execute_script(BOX, plot)[1] <= 800, plot
    page.screen()


def test_keys_do_what_the_list_says(page: Browser) -> None:
    page.view("now")
    body = page.find("body")
    body.send_keys("?")
    page.until(lambda: "STOP: bring the bench to rest" in page.text("#sheet-body"))
    body.send_keys(Keys.ESCAPE)
    page.until(lambda: not page.find("#sheet").is_displayed())
    body.send_keys("/")
    page.until(lambda: page.find("#recordings").is_displayed())
    # what is written into a field is no act
    page.find("#q-words").send_keys("1?")
    assert page.find("#recordings").is_displayed()
    page.find("#q-words").clear()
    page.driver.execute_script("document.activeElement.blur()")
    body.send_keys("1")
    page.until(lambda: page.find("#now").is_displayed())


def test_a_gearbox_is_followed_over_its_campaigns(page: Browser) -> None:
    page.view("trend")
    page.until(lambda: "Since month-7: 2 of" in page.text("#trend-lines"))
    assert page.text("#trend-charts figure b") == "friction at 5 °/s, 30 °C"
    assert len(page.all("#trend-charts figure.outside")) == 2
    label = page.attribute("[data-key='friction.5'] svg", "aria-label")
    assert label.startswith("friction at 5 °/s, 30 °C: last 660 ± 1.0 mN·m, 5 campaigns, limits 59")
    assert label.endswith("OUTSIDE")
    assert len(page.all("#trend-campaigns tbody tr")) == 5
    page.size(1280, 1500)
    page.shot("operator-trend")
    page.size(1280, 1100)
    assert page.problems() == []


def test_the_book_is_searched_and_remarked_upon(page: Browser) -> None:
    page.view("place")
    page.click("#book-remark")
    fields = page.all("#sheet-body input")
    fields[0].send_keys("seal changed")
    fields[1].clear()
    fields[1].send_keys("Ann")
    page.click("#sheet-acts button", "Write it down")
    page.until(lambda: "seal changed" in page.text("#book"))
    page.find("#book-words").send_keys("seal ann")
    page.until(lambda: len(page.all("#book tbody tr")) == 1)
    page.find("#book-words").clear()
    page.find("#book-words").send_keys("unobtainium")
    page.until(lambda: "no such entry" in page.text("#book"))
    page.find("#book-words").clear()


def test_two_campaigns_are_compared(page: Browser) -> None:
    page.view("plan")
    page.click("#plan-compare")
    page.until(lambda: "kinds of points are the same in both" in page.text("#compared"))
    assert "energy, kWh" in page.text("#compared")
    page.find("body").send_keys(Keys.ESCAPE)
    assert page.problems() == []
