"""A page without the token of its service: it asks for it, once, and shows nothing before."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.browser.conftest import Browser, served_apart


def test_a_missing_token_is_asked_for(
    new_browser: Callable[[str], Browser], tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("token")
    token = "a-token-of-a-laboratory-0417-0417"
    (folder / "token").write_text(token + "\n", "utf-8")
    (folder / "token").chmod(0o600)
    with served_apart(folder, "--token-file", str(folder / "token")) as address:
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
