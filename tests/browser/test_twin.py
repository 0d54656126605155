"""The twin's switch, in a real browser: a run that is started from the page is watched by the model chosen."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.browser.conftest import Browser, page_over

CAUGHT = """const before = window.fetch;
window.fetch = (to, how) => {
  if (how?.method !== "POST" || !String(to).endsWith("/runs")) return before(to, how);
  window.sent = JSON.parse(how.body);
  const headers = { "Content-Type": "application/json" };
  return Promise.resolve(new Response('{"state": "queued"}', { status: 200, headers }));
};"""


@pytest.fixture(scope="module")
def page(new_browser: Callable[[str], Browser], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The page where one campaign was identified."""
    root = tmp_path_factory.mktemp("recordings")
    analysis = root / "recordings" / ".service" / "analyses" / "one"
    analysis.mkdir(parents=True)
    (analysis / "model.json").write_text("{}", "utf-8")
    (analysis / "analysis.json").write_text(
        '{"id": "one", "kind": "identify", "folder": "spring", "asked_at": "2026-11-02T09:00:00+00:00", "by": "Ann",'
        ' "state": "done"}',
        "utf-8",
    )
    with page_over(root, new_browser) as browser:
        yield browser


def test_a_campaign_is_started_with_the_model_that_watches_it(page: Browser) -> None:
    page.click("#acts [data-act=start]")
    page.until(lambda: page.text("#sheet-title") == "Take the controls")
    page.find("#name").clear()
    page.find("#name").send_keys("Ann")
    page.click("#sheet-acts button", "Take the controls")
    page.until(lambda: page.text("#sheet-title") == "Start a campaign")
    page.driver.execute_script(CAUGHT)
    assert "Watched by" in page.text("#sheet-body")
    page.click("#sheet .option", "The model of spring")
    page.click("#sheet .option", "Begin no further point")
    page.click("#sheet-acts button", "Start")
    page.until(lambda: page.driver.execute_script("return window.sent"))
    sent = page.driver.execute_script("return window.sent")
    assert (sent["twin"], sent["twin_pause"]) == ("one", True)


def test_without_a_choice_nothing_watches(page: Browser) -> None:
    page.driver.execute_script("window.sent = null")
    page.click("#acts [data-act=start]")
    page.until(lambda: page.text("#sheet-title") == "Start a campaign")
    page.click("#sheet-acts button", "Start")
    page.until(lambda: page.driver.execute_script("return window.sent"))
    assert "twin" not in page.driver.execute_script("return window.sent")


SHOWN = """const [message, done] = arguments;
Promise.all([import("/static/state.js"), import("/static/now.js")]).then(([{ state }, now]) => {
  state.spectrum = message;
  now.spectrum();
  requestAnimationFrame(() => requestAnimationFrame(done));
});"""
COLOURED = """const still = { willReadFrequently: true };
const probe = document.createElement("canvas").getContext("2d", still);
const canvas = document.querySelector("#plot-curve canvas");
const style = getComputedStyle(document.documentElement);
probe.fillStyle = style.getPropertyValue("--card"); probe.fillRect(0, 0, 1, 1);
probe.fillStyle = style.getPropertyValue("--model-band"); probe.fillRect(0, 0, 1, 1);
const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
const copy = document.createElement("canvas");
[copy.width, copy.height] = [canvas.width, canvas.height];
const to = copy.getContext("2d", still);
to.drawImage(canvas, 0, 0);
const all = to.getImageData(0, 0, canvas.width, canvas.height).data;
let seen = 0;
for (let i = 0; i < all.length; i += 4) {
  const alpha = all[i + 3] / 255;
  const over = [0, 1, 2].map(k => all[i + k] * alpha + 255 * (1 - alpha));
  if (Math.abs(over[0] - r) + Math.abs(over[1] - g) + Math.abs(over[2] - b) < 12) seen++;
}
return seen;"""


def revolution(**more: Any) -> dict[str, Any]:
    error = [20e-6 * math.sin(3 * 2 * math.pi * (i + 0.5) / 512) for i in range(512)]
    known = {"torque": 100.0, "velocity": 0.1, "temperature": 30.0, "rms": 14e-6, "what": "constant_velocity"}
    return {"type": "spectrum", "amplitude": [0.0, 0.0, 20e-6], "curve": error, "at": 1.0, **known, **more}


def test_the_band_of_the_model_is_drawn_or_it_says_why_not(page: Browser) -> None:
    page.driver.execute_script("document.querySelector('#sheet').close()")
    page.view("now")
    page.driver.execute_async_script(SHOWN, revolution())
    assert "No model is drawn" in page.text("#model-text")
    assert page.driver.execute_script(COLOURED) < 100
    curve = revolution()["curve"]
    model = {"model": [0.0, 0.0, 20e-6], "model_curve": curve}
    page.driver.execute_async_script(SHOWN, revolution(**model, model_why="there is no covariance"))
    assert "No band: there is no covariance." in page.text("#model-text")
    band = {"model_band": [15e-6] * 512, "model_inside": 0.87, "model_band_share": 0.95, "model_left": 6.5e-6}
    page.driver.execute_async_script(SHOWN, revolution(**model, **band, model_why=""))
    assert "Band: where 95 % should lie" in page.text("#model-text")
    assert "(6.5 µrad RMS); 87 % of this revolution do" in page.text("#model-text")
    assert page.driver.execute_script(COLOURED) > 1000
    page.driver.execute_async_script(SHOWN, revolution(model_why="it was never fitted in this direction"))
    assert "The model is not drawn: it was never fitted in this direction." in page.text("#model-text")
    assert page.driver.execute_script(COLOURED) < 100
    assert page.problems() == []
