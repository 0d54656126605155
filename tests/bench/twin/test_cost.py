"""What watching costs is measured on recordings, and refused where nothing would be tested."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from bench.errors import RecordingError
from bench.twin.proof.cost import cost
from tests.bench.twin.conftest import Known


def test_the_share_is_processor_time_over_recorded_time(known: Known) -> None:
    found = cost(known.model, known.without)
    assert found["recordings"] == len(list(known.without.glob("*.h5")))
    assert found["share"] == pytest.approx(found["processor_s"] / found["recorded_s"], abs=1e-3)
    assert 0.0 < found["longest_s"] <= found["processor_s"]
    assert found["share"] < 0.1


def test_too_few_recordings_are_refused(known: Known, tmp_path: Path) -> None:
    for path in sorted(known.without.glob("*.h5"))[:3]:
        shutil.copy(path, tmp_path)
    with pytest.raises(RecordingError, match="are needed"):
        cost(known.model, tmp_path)
