"""What may stand behind ``--simulation``, and what is said of a file that is none of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.errors import ConfigurationError
from bench.foreign.opening import open_base


@pytest.mark.parametrize("content", [b"t;q\n0;1\n", b"", b"\xb0C"])
def test_a_file_that_is_no_simulation_is_refused_with_what_may_be(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(ConfigurationError, match=r"a\.csv: is no simulation; .* model\.json, an FMU .* module:name"):
        open_base(str(tmp_path / "a.csv"))


@pytest.mark.parametrize("content", [b"{}", b"\xef\xbb\xbf\n {"])
def test_a_json_file_is_left_to_who_reads_it(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "model").write_bytes(content)
    assert open_base(str(tmp_path / "model")) is None
    assert open_base(str(tmp_path / "not-there.json")) is None
