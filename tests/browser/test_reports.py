"""Reports in a real browser: beside the last one of the same gearbox, and what they leave open asked of the bench."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from tests.bench.recording.builders import write
from tests.browser.conftest import Browser, page_over

REPORT = "<!doctype html><title>report</title><h1>What the simulation leaves out</h1><p>{name}</p>"


def finding(effect: str, status: str = "named", confidence: float = 0.95) -> dict[str, Any]:
    content = {"effect": effect, "name": f"{effect} in words", "status": status, "confidence": confidence}
    return content | {"channel": "motor_torque", "location": {"text": "everywhere"}}


def report(root: Path, id_: str, folder: str, asked_at: str, error: float, *findings: dict[str, Any]) -> None:
    """A finished mismatch report on a folder of one recording."""
    (root / folder).mkdir(parents=True)
    write(root / folder / "r001.h5", rows=60, gearbox_serial="RH-0417", started_at=datetime(2026, 3, 1, 9, tzinfo=UTC))
    analysis = root / ".service" / "analyses" / id_
    analysis.mkdir(parents=True)
    about = {"id": id_, "kind": "mismatch", "folder": folder, "asked_at": asked_at, "by": "Ann", "state": "done"}
    (analysis / "analysis.json").write_text(json.dumps(about), "utf-8")
    channel = {"channel": "motor_torque", "unit": "N*m", "held_out_rmse_after": error}
    content = {"format": "bench-mismatch-report", "findings": list(findings), "channels": [channel]}
    (analysis / "report.json").write_text(json.dumps(content), "utf-8")
    (analysis / "report.html").write_text(REPORT.format(name=folder), "utf-8")


@pytest.fixture(scope="module")
def page(new_browser: Callable[[str], Browser], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The page over two reports of one gearbox; the later one leaves two findings open."""
    place = tmp_path_factory.mktemp("reports")
    root = place / "recordings"
    report(root, "20260301-a", "spring", "2026-03-01T09:00:00+00:00", 0.1, finding("te.drift"), finding("te.hump"))
    open_ones = (finding("friction.stribeck", "ambiguous"), finding("friction.churning", confidence=0.6))
    report(root, "20261101-b", "autumn", "2026-11-01T09:00:00+00:00", 0.2, finding("te.drift"), *open_ones)
    with page_over(place, new_browser) as browser:
        browser.view("analysis")
        yield browser


def test_a_report_is_read_beside_the_last_one_of_the_same_gearbox(page: Browser) -> None:
    page.click("[data-analysis='20261101-b'] button", "Read the report")
    page.until(lambda: len(page.all("#report-since p")) == 3)
    lines = [line.text for line in page.all("#report-since p")]
    assert lines[0] == (
        "Compared with the report on spring (2026-03-01), the same gearbox RH-0417: 1 of 2 findings are found again."
    )
    assert "friction.stribeck in words (ambiguous, motor torque)" in lines[1]
    assert "Found no more: te.hump in words" in lines[1]
    assert lines[2] == "Error of the simulation with what was found: motor torque 0.1 → 0.2 N·m."
    page.driver.switch_to.frame(page.find("#report"))
    page.until(lambda: "autumn" in page.text("body"))
    page.driver.switch_to.default_content()


def test_another_report_leaves_nothing_of_the_one_before(page: Browser) -> None:
    page.click("[data-analysis='20260301-a'] button", "Read the report")
    page.until(lambda: "spring" in page.text("#report-title"))
    page.until(lambda: page.driver.execute_script("return document.querySelector('#report').src.includes('0301-a')"))
    assert page.text("#report-since") == ""


LATE = """const before = window.fetch;
window.fetch = (to, how) => {
  const answer = before(to, how);
  if (String(to).endsWith("20261101-b/since")) {
    return answer.then(late => new Promise(done => { window.late = () => done(late); }));
  }
  if (String(to).endsWith("20260301-a/since")) answer.then(() => setTimeout(() => { window.other = true; }, 200));
  return answer;
};"""


def test_an_answer_that_comes_late_is_not_shown_under_another_report(page: Browser) -> None:
    page.driver.execute_script(LATE)
    page.click("[data-analysis='20261101-b'] button", "Read the report")
    page.until(lambda: page.driver.execute_script("return Boolean(window.late)"))
    page.click("[data-analysis='20260301-a'] button", "Read the report")
    page.until(lambda: page.driver.execute_script("return window.other"))
    page.driver.execute_script("window.late()")
    page.driver.execute_async_script("setTimeout(arguments[0], 500)")
    assert "spring" in page.text("#report-title")
    assert page.text("#report-since") == ""


ASKS = """const [asks, runs, done] = arguments;
Promise.all([import("/static/state.js"), import("/static/analysis.js")]).then(([{ state }, analysis]) => {
  const one = state.analyses.find(other => other.kind === "investigate");
  state.analyses = [{ ...one, state: "running", what: "experiment 1 waits", asks }];
  state.runs = runs;
  state.allowed = ["approve"];
  analysis.analyses();
  done();
});"""
TASK = {
    "number": 1, "sequence": "reversal", "repeat": 1, "preparation": False, "load_torque_nm": 400.0,
    "velocity_rad_s": 0.1, "temperature_degc": None, "start_s": 0.0, "duration_s": 120.0, "energy_j": 3600.0,
    "expected_end_temperature_degc": 26.0, "expected_motor_torque_nm": 1.5,
}  # fmt: skip


def test_what_is_open_is_asked_of_the_bench(page: Browser) -> None:
    assert "2 findings are ambiguous, unknown, or not sure." in page.text("[data-analysis='20261101-b']")
    assert "Investigate" not in page.text("[data-analysis='20260301-a']")
    page.click("[data-analysis='20261101-b'] button", "Investigate what is open")
    page.until(lambda: page.text("#sheet-title") == "Investigate autumn")
    assert "Nothing moves until" in page.text("#sheet-body")
    hours = page.find("#ask-hours")
    hours.clear()
    hours.send_keys("1.5")
    page.find("#sheet-body input[type=text]").send_keys("Ann")
    page.click("#sheet-acts button", "Design the first experiment")
    page.until(lambda: "Investigation: autumn" in page.text("#analyses"))
    card = "#analyses .card:first-child"
    end = "[...document.querySelectorAll(arguments[0])].find(one => one.innerText === 'End the investigation')?.click()"

    def over() -> bool:
        # its process is of low priority: on a machine that is free it has refused the other gearbox by then
        page.driver.execute_script(end, f"{card} .acts button")
        return any(word in page.text(f"{card} .line") for word in ("cancelled", "failed"))

    page.until(over, "the investigation ends")
    page.until(lambda: page.text(f"{card} .steps summary").startswith("What it said"))
    plan = {"points": 1, "duration_s": 120.0, "heating_s": 0.0, "energy_j": 3600.0, "tasks": [TASK]}
    plan["start_temperature_degc"] = 25.0
    run = {"id": "run-1", "state": "proposed", "title": "experiment 1 on autumn", "by": "Ann", "asked_at": ""}
    page.driver.execute_async_script(ASKS, {"number": 1, "run": "run-1", "plan": plan}, [run])
    assert "0.00 kWh" in page.text(".experiment")
    assert "2 min" in page.text(".experiment table")
    assert [b.text for b in page.all(".experiment button")] == ["Let it begin", "Refuse"]
    assert page.find(".experiment button").is_enabled()
    assert "End the investigation" in page.text(card)
    page.driver.execute_async_script(ASKS, {"number": 1, "run": "run-1", "plan": plan}, [{**run, "state": "running"}])
    assert page.all(".experiment button") == []
