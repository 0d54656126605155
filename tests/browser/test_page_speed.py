"""The benchmark of the page measures what it says; how fast it is depends on the machine and is no test."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from bench.matrix.page_speed import PAGES, measure_page
from bench.service.runs.allowed import RUNNING
from tests.browser.conftest import Browser


def test_four_pages_are_watched(
    new_browser: Callable[[str], Browser], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seconds = 3.0
    monkeypatch.setattr("bench.matrix.page_speed._PAN_S", 1.0)
    # values come while the zero of the torque sensor is measured as they do later; that takes half a minute
    found = measure_page(seconds, tmp_path, phases=RUNNING)
    assert found.pages == PAGES == 4
    # values come five times a second at most, into each page
    assert PAGES < found.values <= PAGES * (5 * seconds + 10)
    assert found.value_p95_s is not None
    assert found.value_longest_s is not None
    assert 0.0 < found.value_p95_s <= found.value_longest_s
    assert found.paint_s is not None
    assert found.paint_s > 0.0
    assert 0.0 < found.frames_per_s < 200.0
    assert 0.0 < found.service_share < 1.0
