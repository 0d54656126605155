"""STOP in a real browser: what is not confirmed is said within a second, and who pressed, when, and what was seen."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bench.configuration import load_bench
from bench.locks import service_for
from tests.browser.conftest import Browser, served_apart
from tests.browser.test_operator import running, state

SAID_S = 1.0
NOT_CONFIRMED = "STOP not confirmed — use the emergency stop"
PRESS_AND_WATCH = """const [wanted, done] = arguments, begin = performance.now();
const place = document.getElementById('stopped');
document.getElementById('stop').dispatchEvent(new PointerEvent('pointerdown'));
const look = () => {
  const text = place.hidden ? '' : place.innerText, after = (performance.now() - begin) / 1000;
  if (text.includes(wanted) || after > 20) done([text, after]);
  else setTimeout(look, 10);
};
look();"""
"""Presses STOP and gives what the page says once it says what is wanted, and after how many seconds."""


@pytest.fixture
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a short path: that of a socket in it may have 107 bytes."""
    return tmp_path_factory.mktemp("stop")


@pytest.fixture
def locks(folder: Path) -> Path:
    return folder / "locks"


@pytest.fixture
def address(folder: Path) -> Iterator[str]:
    with served_apart(folder) as url:
        yield url


@pytest.fixture
def ann(new_browser: Callable[[str], Browser], address: str) -> Iterator[Browser]:
    """A browser whose run measures at the clock's pace."""
    browser = new_browser(address)
    browser.open()
    browser.click("#acts [data-act=start]")
    browser.find("#name").send_keys("Ann")
    browser.click("#sheet-acts button", "Take the controls")
    browser.click("#sheet .option", "quick")
    browser.click("#sheet-acts button", "Start")
    browser.until(lambda: browser.text("#phase-name") in ("Measuring the zero", "Measuring", "Warming up"))
    yield browser
    browser.driver.close()


def ended(pid: int) -> bool:
    """Whether a process has ended, waited for by its parent or not."""
    try:
        return not Path(f"/proc/{pid}/cmdline").read_bytes()
    except FileNotFoundError:
        return True


def hang(address: str) -> int:
    service = service_for(load_bench("rh380n"))
    assert service is not None
    assert service["url"] == address
    os.kill(service["pid"], signal.SIGSTOP)
    return int(service["pid"])


def test_a_hung_service_is_passed_by_and_the_page_says_what_was_seen(ann: Browser, address: str) -> None:
    run = running(address)
    assert run is not None
    ann.until(lambda: state(address, "state")["stop_port"] is not None)
    pid = hang(address)
    try:
        # the run's own listener confirms it
        text, after_s = ann.driver.execute_async_script(PRESS_AND_WATCH, "STOP pressed by Ann")
        assert "STOP pressed by Ann" in text
        assert after_s <= SAID_S
        ann.until(lambda: ended(run["pid"]))
    finally:
        os.kill(pid, signal.SIGCONT)
    ann.until(lambda: running(address) is None)
    ann.until(lambda: state(address, "state")["stop"] is not None)
    stopped = state(address, "state")["stop"]
    assert (stopped["by"], stopped["run"]) == ("Ann", run["id"])
    # the listener may end with its run before the page has asked it again; the service knows from the record
    ann.until(lambda: "seen on both shafts" in ann.text("#stopped"))
    assert f"At rest after {stopped['at_rest_after_s']:.2f} s" in ann.text("#stopped")


def test_what_nobody_confirms_is_said_within_a_second(ann: Browser, address: str) -> None:
    run = running(address)
    assert run is not None
    os.kill(run["pid"], signal.SIGSTOP)
    pid = hang(address)
    try:
        text, after_s = ann.driver.execute_async_script(PRESS_AND_WATCH, NOT_CONFIRMED)
        assert NOT_CONFIRMED in text
        assert after_s <= SAID_S
    finally:
        os.kill(run["pid"], signal.SIGCONT)
        os.kill(pid, signal.SIGCONT)
    # as soon as they go on the press gets through
    ann.until(lambda: running(address) is None)
    ann.until(lambda: "STOP pressed by Ann" in ann.text("#stopped"))
    assert NOT_CONFIRMED not in ann.text("#stopped")


def test_every_page_says_who_pressed_stop(ann: Browser, address: str, new_browser: Callable[[str], Browser]) -> None:
    bob = new_browser(address)
    bob.open()
    bob.driver.execute_script("localStorage.setItem('name', 'Bob')")
    text, _ = bob.driver.execute_async_script(PRESS_AND_WATCH, "STOP pressed by Bob")
    assert "STOP pressed by Bob" in text
    assert NOT_CONFIRMED not in text
    ann.until(lambda: "STOP pressed by Bob" in ann.text("#stopped"))
    ann.until(lambda: ann.text("#phase-name") == "Ready")
    assert ann.text("#phase-label") == "nothing runs"
    bob.driver.close()
