"""A real browser: Debian's Chromium with its driver; skips with the reason where there is none."""

from __future__ import annotations

import contextlib
import inspect
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException, WebDriverException
from selenium.webdriver.common.by import By

from tests.bench.service.conftest import served

REQUIRE = "BENCH_REQUIRE_BROWSER"
"""Environment variable: ``1`` turns a test that skips for want of a browser into a failure."""
SCREENSHOTS = "BENCH_SCREENSHOTS"
"""Environment variable: ``1`` lets the tests make the screenshots of docs/operator.md anew."""
IMAGES = Path(__file__).parents[2] / "docs" / "images"
CENTRE = "arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})"
WHERE = """const [element, done] = arguments;
const where = () => { const {x, y, width, height} = element.getBoundingClientRect(); done([x, y, width, height]); };
requestAnimationFrame(() => requestAnimationFrame(where));"""
AN_ANALYSIS = 4.0
"""deadlines within which an analysis is done: it computes, and on a busy machine gets a third of a processor"""
DEADLINE_S = float(os.environ.get("BENCH_BROWSER_DEADLINE", "60"))


def _missing(why: str) -> None:
    if os.environ.get(REQUIRE) == "1":
        pytest.fail(f"{why} ({REQUIRE}=1)")
    pytest.skip(why)


class Browser:
    """One window."""

    def __init__(self, driver: webdriver.Chrome, address: str, images: Path) -> None:
        self.driver, self._address, self._images = driver, address, images

    def open(self) -> None:
        self.driver.get(self._address)
        self.until(lambda: self.text("#phase-name") not in ("", "…"))

    def find(self, selector: str) -> Any:
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def all(self, selector: str) -> list[Any]:
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def text(self, selector: str) -> str:
        return str(self.driver.execute_script("return document.querySelector(arguments[0])?.innerText ?? ''", selector))

    def attribute(self, selector: str, name: str) -> str:
        """In one script, for what is found may be drawn anew before it is asked."""
        script = "return document.querySelector(arguments[0])?.getAttribute(arguments[1]) ?? ''"
        return str(self.driver.execute_script(script, selector, name))

    def click(self, selector: str, containing: str = "") -> None:
        """Click the first that is there, in sight and enabled."""

        def clicked() -> bool:
            for element in self.all(selector):
                try:
                    if element.is_displayed() and element.is_enabled() and containing in element.text:
                        # the middle of the window: at its edge the header, which stays, may lie over it
                        self.driver.execute_script(CENTRE, element)
                        element.click()
                        return True
                except (StaleElementReferenceException, WebDriverException):
                    # drawn anew between looking and clicking
                    continue
            return False

        self.until(clicked, f"{selector} {containing}")

    def view(self, name: str) -> None:
        self.click(f"#tabs [data-view={name}]")

    def until(self, what: Callable[[], Any], text: str = "", deadlines: float = 1.0) -> None:
        deadline = time.monotonic() + deadlines * DEADLINE_S
        while not what():
            if time.monotonic() > deadline:
                self.driver.save_screenshot(str(Path(tempfile.gettempdir()) / "bench-browser-failed.png"))
                pytest.fail(f"it did not happen in time: {text or inspect.getsource(what).strip()}; {self.problems()}")
            time.sleep(0.05)

    def still(self, element: Any) -> None:
        """Wait until an element stays where it is: a gesture of several steps aims at one place of the window."""
        seen: list[Any] = []

        def stays() -> bool:
            # two frames apart, for scrolling and drawing happen between frames
            seen.append(self.driver.execute_async_script(WHERE, element))
            return len(seen) > 1 and seen[-1] == seen[-2]

        self.until(stays, "the element stays where it is")

    def size(self, width: int, height: int) -> None:
        self.driver.set_window_size(width, height)

    def screen(self, width: int = 0, height: int = 0) -> None:
        """Show exactly so many pixels, as a phone does (a window is never so narrow); without numbers the window's."""
        if width:
            values = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
            self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", values)
        else:
            self.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})

    def shot(self, name: str) -> None:
        self.driver.execute_script("document.activeElement?.blur()")
        self.driver.save_screenshot(str(self._images / f"{name}.png"))

    def problems(self) -> list[str]:
        """What the console says beyond the loss of the service, which one test makes itself."""
        lines: list[dict[str, str]] = self.driver.get_log("browser")  # type: ignore[no-untyped-call]
        return [line["message"] for line in lines if "net::ERR_" not in line["message"]]


@pytest.fixture(scope="module")
def new_browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str], Browser]]:
    """Opens windows on an address; they close with the file, for a page without its service keeps asking for it."""
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    driver_path = shutil.which("chromedriver")
    if chromium is None or driver_path is None:
        _missing("there is no browser here: Chromium and chromedriver (Debian: chromium, chromium-driver)")
    images = IMAGES if os.environ.get(SCREENSHOTS) == "1" else tmp_path_factory.mktemp("screenshots")
    options = webdriver.ChromeOptions()
    options.binary_location = str(chromium)
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--lang=en-GB"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    drivers: list[webdriver.Chrome] = []

    def new(address: str) -> Browser:
        try:
            driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(str(driver_path)))
        except WebDriverException as error:
            _missing(f"there is no browser here that starts: {error.msg}")
        drivers.append(driver)
        driver.set_window_size(1280, 1100)
        return Browser(driver, address, images)

    yield new
    for driver in drivers:
        driver.quit()


@contextlib.contextmanager
def served_apart(folder: Path, *options: str) -> Iterator[str]:
    """``bench serve`` on the recordings of a folder, its locks and its state beside them; gives its address."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BENCH_RUNTIME", str(folder / "locks"))
        patch.setenv("BENCH_STATE", str(folder / "state"))
        with served(folder / "recordings", *options) as address:
            yield address


@contextlib.contextmanager
def page_over(folder: Path, new_browser: Callable[[str], Browser]) -> Iterator[Browser]:
    """A window on the page of a service as :func:`served_apart` starts it."""
    with served_apart(folder) as address:
        browser = new_browser(address)
        browser.open()
        yield browser
