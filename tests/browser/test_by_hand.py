"""By hand, in a real browser: a button that is held moves the bench, let go it stops; the torque sensor is tared."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from selenium.webdriver import ActionChains

from tests.browser.conftest import Browser, served_apart
from tests.browser.test_operator import state

SPEED = "return parseFloat(document.getElementById('v-speed').innerText.replace('−', '-')) || 0"


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder = tmp_path_factory.mktemp("by-hand")
    with served_apart(folder) as url:
        yield url


@pytest.fixture(scope="module")
def ann(new_browser: Callable[[str], Browser], address: str) -> Iterator[Browser]:
    browser = new_browser(address)
    browser.open()
    browser.click("#holder")
    browser.find("#name").send_keys("Ann")
    browser.click("#sheet-acts button", "Take the controls")
    browser.until(lambda: "You hold the controls" in browser.text("#holder"))
    yield browser
    browser.driver.close()


def last_run(address: str) -> dict[str, Any]:
    run: dict[str, Any] = state(address, "runs")["runs"][-1]
    return run


def test_it_moves_while_the_button_is_held_and_no_longer(ann: Browser, address: str) -> None:
    ann.click("#acts [data-act=jog]")
    button = ann.find("[data-jog='1']")
    ActionChains(ann.driver).click_and_hold(button).perform()
    ann.until(lambda: "It moves" in ann.text("#jog-state"))
    ann.until(lambda: ann.driver.execute_script(SPEED) > 0.1)
    ann.shot("operator-jog")
    assert last_run(address)["state"] == "running"
    ActionChains(ann.driver).release().perform()
    ann.until(lambda: last_run(address)["state"] == "ended")
    # to let go is the end that was meant: no alarm, and nothing is held
    assert last_run(address)["end"]["kind"] == "finished"
    assert last_run(address)["end"]["text"] == "let go"
    assert state(address, "state")["alarms"] == []
    ann.until(lambda: ann.text("#phase-name") == "Ready")
    ann.until(lambda: abs(ann.driver.execute_script(SPEED)) < 0.05)
    ann.click("#sheet-acts button", "Close")


def test_a_page_that_closes_lets_go(ann: Browser, address: str) -> None:
    ann.until(lambda: ann.find("#acts [data-act=jog]").is_enabled())
    ann.click("#acts [data-act=jog]")
    ActionChains(ann.driver).click_and_hold(ann.find("[data-jog='-1']")).perform()
    ann.until(lambda: "It moves" in ann.text("#jog-state"))
    run = last_run(address)["id"]
    ann.driver.get("about:blank")
    ann.until(lambda: last_run(address)["state"] == "ended")
    assert last_run(address)["id"] == run
    assert last_run(address)["end"]["text"] == "let go"
    ActionChains(ann.driver).release().perform()
    ann.open()


def test_the_torque_sensor_is_tared_and_the_zero_is_told(ann: Browser, address: str) -> None:
    ann.until(lambda: ann.find("#acts [data-act=tare]").is_enabled())
    ann.click("#acts [data-act=tare]")
    ann.click("#sheet-acts button", "Tare")
    ann.until(lambda: "the unloaded torque sensor reads" in ann.text("#tare-text"))
    assert "standard deviation" in ann.text("#tare-text")
    end = last_run(address)["end"]
    assert ann.text("#tare-text") == end["text"]
    assert end["tare"]["readings"] > 1000
    ann.click("#sheet-acts button", "Close")
    ann.view("place")
    ann.until(lambda: "Taring of the torque sensor ended: the unloaded torque sensor reads" in ann.text("#book"))
    assert ann.problems() == []
