"""The picture of one campaign: drawn from what was stored, refused where nothing was."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bench.errors import BenchError
from bench.twin.proof.picture import draw

ROW: dict[str, Any] = {
    "key": "a pin chips/clear/1",
    "change": "a pin chips",
    "level": "clear",
    "began": 20,
    "noticed": 24,
}


def test_a_course_is_drawn(tmp_path: Path) -> None:
    course = [0.0] * 21 + [1.0, 3.0, 4.0, 9.0, 30.0]
    path = draw(ROW | {"evidence": course}, tmp_path / "deep" / "twin.png")
    assert path.read_bytes().startswith(b"\x89PNG")
    unchanged = draw(ROW | {"evidence": [0.0] * 20, "began": None, "noticed": None}, tmp_path / "none.png")
    assert unchanged.stat().st_size > 1000


def test_a_row_without_its_course_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BenchError, match="a pin chips/clear/1"):
        draw(ROW, tmp_path / "twin.png")
