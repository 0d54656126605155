"""The twin's switch, in a real browser: a run that is started from the page is watched by the model chosen."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from tests.bench.service.conftest import served
from tests.browser.conftest import Browser

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
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BENCH_RUNTIME", str(root / "locks"))
        patch.setenv("BENCH_STATE", str(root / "state"))
        with served(root / "recordings") as address:
            browser = new_browser(address)
            browser.open()
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
