"""A page without the token of its service: it asks for it, once, and shows nothing before."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.browser.conftest import Browser, served_apart


def test_a_missing_token_is_asked_for(new_browser: Callable[[str], Browser], tmp_path: Path) -> None:
    token = "a-token-of-a-laboratory-0417-0417"
    (tmp_path / "token").write_text(token + "\n", "utf-8")
    (tmp_path / "token").chmod(0o600)
    with served_apart(tmp_path, "--token-file", str(tmp_path / "token")) as address:
        page = new_browser(address)
        page.driver.get(address)
        page.until(lambda: page.text("#sheet-title") == "This page needs the token of the service")
        assert page.text("#v-speed") == "–"
        page.find("#token").send_keys("another")
        page.click("#sheet-acts button", "Go on")
        page.until(lambda: page.text("#sheet-problem") == "the token is wrong")
        page.find("#token").clear()
        page.find("#token").send_keys(token)
        page.click("#sheet-acts button", "Go on")
        page.until(lambda: page.text("#phase-name") == "Ready")
        # a cookie stands for it from now on
        page.driver.get(address)
        page.until(lambda: page.text("#phase-name") == "Ready")
        assert not page.find("#sheet").is_displayed()
        page.driver.close()
