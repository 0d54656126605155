"""How fast the operator's page is, in real browsers: four of them on a run at 2 kHz and the clock's pace."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bench.errors import BenchError
from bench.matrix.processes import own_places, post, running_service, state, until

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

PAGES = 4
_BEGINS_S = 180.0
_PAN_S = 4.0
_HOUR_S = 3600
_OPTIONS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1280,800")

_WATCH = """window.seen = [];
const value = document.getElementById('v-torque');
new MutationObserver(() => window.seen.push(performance.now())).observe(value, { childList: true });"""
"""Notes the time of every value that is drawn."""
_PAINT = "return performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? null"
_HOUR = """const [seconds, done] = arguments;
const names = ['motor_velocity_setpoint', 'motor_velocity', 'load_motor_torque_setpoint', 'load_torque', 'temperature'];
import('/static/now.js').then(({ buffers }) => {
  const end = buffers.last()?.end ?? Date.now() / 1000;
  const values = start => Object.fromEntries(names.map(name => [name, [-1, 1, Math.sin(start / 60), 0]]));
  const parts = (count, length) => Array.from({ length: count }, (_, i) => end - (count - i) * length)
    .map(start => ({ start, end: start + length, values: values(start) }));
  buffers.load(parts(3300, 0.2), parts(seconds / 10, 10));
  done(true);
});"""
"""Puts an hour behind the values that are there."""
_PAN = """const [selector, seconds, done] = arguments, over = document.querySelector(selector);
let frames = 0, begin = null;
const step = now => {
  begin ??= now;
  over.dispatchEvent(new WheelEvent('wheel', { deltaX: frames % 200 < 100 ? 4 : -4, bubbles: true, cancelable: true }));
  if (now - begin >= 1000 * seconds) done([frames, now - begin]);
  else { frames += 1; requestAnimationFrame(step); }
};
requestAnimationFrame(step);"""
"""One turn of the wheel a frame, to and fro: gives frames and ms."""


@dataclass(frozen=True, slots=True)
class PageSpeed:
    """What was measured; times in s, ``None`` where nothing was seen.

    ``value_p95_s`` is the 95th percentile of the times between two values drawn, over all pages; ``paint_s`` the
    slowest first contentful paint; ``service_share`` the web process's share of one processor.
    """

    pages: int
    seconds: float
    values: int
    value_p95_s: float | None
    value_longest_s: float | None
    frames_per_s: float
    paint_s: float | None
    service_share: float
    load: float
    processors: int

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def measure_page(
    seconds: float,
    folder: Path,
    report_progress: Callable[[str], None] = lambda _: None,
    phases: Collection[str] = ("measuring",),
) -> PageSpeed:
    """Serve an emulated bench, run its shipped campaign ``quick`` in real time, and watch it in four browsers.

    They are opened as soon as the run is in one of ``phases``.

    Raises
    ------
    BenchError
        If there is no browser, or selenium is not installed.
    """
    with own_places(folder), running_service(folder / "recordings") as (process, address):
        secret = post(address, "controls/take", name="benchmark")["secret"]
        run = post(address, "runs", secret=secret, name="benchmark", campaign="quick", real_time=True)["id"]
        report_progress("the run begins")
        until(lambda: _phase(address) in phases, _BEGINS_S, "the run does not begin to measure")
        with _browsers(address, report_progress) as pages:
            for page in pages:
                page.execute_script(_WATCH)
            report_progress(f"{seconds:g} s of values in {PAGES} pages")
            cpu, begun = _cpu_s(process.pid), time.monotonic()
            time.sleep(seconds)
            share = (_cpu_s(process.pid) - cpu) / (time.monotonic() - begun)
            seen = [np.asarray(page.execute_script("return window.seen"), float) / 1e3 for page in pages]
            gaps = np.concatenate([np.diff(one) for one in seen])
            paints = [page.execute_script(_PAINT) for page in pages]
            report_progress("panning an hour")
            frames = _frames(pages[0])
        post(address, "run/abort", secret=secret, run=run)
        until(lambda: _phase(address) is None, _BEGINS_S, "the run does not end")
    painted = [paint for paint in paints if paint is not None]
    return PageSpeed(
        PAGES,
        seconds,
        sum(one.size for one in seen),
        float(np.percentile(gaps, 95)) if gaps.size else None,
        float(gaps.max()) if gaps.size else None,
        frames,
        max(painted) / 1e3 if painted else None,
        share,
        os.getloadavg()[0],
        os.cpu_count() or 1,
    )


def _phase(address: str) -> str | None:
    """Return the phase of the run that goes on, None without one."""
    if not any(run["state"] in ("running", "queued") for run in state(address, "runs")["runs"]):
        return None
    return str(state(address, "status").get("phase", "opening"))


@contextmanager
def _browsers(address: str, report_progress: Callable[[str], None]) -> Iterator[list[Chrome]]:
    try:
        from selenium import webdriver
        from selenium.common.exceptions import WebDriverException
    except ImportError as error:
        raise BenchError("this needs selenium: pip install 'gearbench[test]'") from error
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    driver = shutil.which("chromedriver")
    if chromium is None or driver is None:
        raise BenchError("this needs Chromium and chromedriver (Debian: chromium, chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for option in _OPTIONS:
        options.add_argument(option)
    pages: list[Chrome] = []
    try:
        for number in range(PAGES):
            report_progress(f"page {number + 1} of {PAGES}")
            page = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
            pages.append(page)
            page.set_script_timeout(120)
            page.get(address)
        until(lambda: all(_draws(page) for page in pages), _BEGINS_S, "the pages show no plots")
        yield pages
    except WebDriverException as error:
        raise BenchError(f"the browser failed: {error.msg}") from error
    finally:
        for page in pages:
            page.quit()


def _draws(page: Chrome) -> bool:
    return bool(page.execute_script("return document.querySelectorAll('#now .u-over').length > 2"))


def _frames(page: Chrome) -> float:
    """Frames a second while a stretch of an hour's plot is moved by the wheel."""
    from selenium.webdriver import ActionChains

    page.execute_async_script(_HOUR, _HOUR_S)
    page.execute_script(
        "[...document.querySelectorAll('#windows button')].find(one => one.innerText === '1 h').click()"
    )
    time.sleep(1.0)
    over = page.find_element("css selector", "#plot-torque .u-over")
    ActionChains(page, duration=50).move_to_element_with_offset(over, -60, 0).click_and_hold().move_by_offset(
        90, 0
    ).release().perform()
    until(lambda: bool(page.find_elements("css selector", "#plot-torque.zoomed")), 20.0, "the plot does not zoom")
    frames, ms = page.execute_async_script(_PAN, "#plot-torque .u-over", _PAN_S)
    return float(1e3 * frames / ms)


def _cpu_s(pid: int) -> float:
    """Processor time of a process so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text("utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
