"""Files that claim what they do not hold: one sentence each, before memory is taken."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from bench.errors import RecordingError
from bench.recording import Recording
from bench.recording.validation import validate
from tests.bench.recording import builders


def _many_rows(file: h5py.File) -> None:
    for channel in file["channels"].values():
        channel.resize((3_000_000_000,))


def _never_stored(file: h5py.File) -> None:
    for channel in file["channels"].values():
        channel.resize((90_000_000,))


def _external(file: h5py.File) -> None:
    del file["channels/load_angle"]
    file["channels/load_angle"] = h5py.ExternalLink("other.h5", "/channels/load_angle")


def _soft(file: h5py.File) -> None:
    del file["channels/load_angle"]
    file["channels/load_angle"] = h5py.SoftLink("/channels/motor_angle")


def _elsewhere(file: h5py.File) -> None:
    del file["channels/load_angle"]
    file["channels"].create_dataset("load_angle", (3000,), "i8", external=[("raw.bin", 0, 24_000)])


def _virtual(file: h5py.File) -> None:
    del file["channels/load_angle"]
    layout = h5py.VirtualLayout((3000,), "i8")
    layout[:] = h5py.VirtualSource("other.h5", "x", (3000,))
    file["channels"].create_virtual_dataset("load_angle", layout)


def _wide_chunk(file: h5py.File) -> None:
    del file["channels/load_angle"]
    file["channels"].create_dataset(
        "load_angle", (3000,), "i8", chunks=(50_000_000,), maxshape=(None,), compression="gzip"
    ).id.write_direct_chunk((0,), b"tiny", 0)


def _many_events(file: h5py.File) -> None:
    file["events/time"].resize((2_000_000_000,))


def _long_text(file: h5py.File) -> None:
    del file["config"]
    file.create_dataset("config", (1,), f"S{2**31 - 1}", chunks=(1,))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (_many_rows, "claims 3000000000 rows, at most 100000000 are read"),
        (_never_stored, "were never stored"),
        (_external, "/channels/load_angle is a link to the file 'other.h5'"),
        (_soft, "/channels/load_angle is a soft link to '/channels/motor_angle'"),
        (_elsewhere, "/channels/load_angle has its samples in other files"),
        (_virtual, "/channels/load_angle has its samples in other files"),
        (_wide_chunk, "/channels/load_angle claims 400000000 bytes in 4 that are stored"),
        (_many_events, "/events/time claims 2000000000 rows, at most 1000000 are read"),
        (_long_text, "/config claims 2147483647 bytes, at most 16777216 are read"),
    ],
)
def test_claims_are_refused(tmp_path: Path, change: Callable[[h5py.File], None], sentence: str) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(RecordingError) as caught:
        Recording.open(path)
    assert sentence in str(caught.value)
    assert str(caught.value).startswith(f"{path}: ")
    assert any(sentence in violation for violation in validate(path).violations)


def test_what_was_written_since_is_read_where_it_lies_now(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    recording = Recording.open(path)
    other = builders.write(tmp_path / "b.h5", rows=5000, recording_id="a")
    with h5py.File(other, "r+") as file:
        file["channels/cycle"][:] = np.arange(5000) * 3
    other.replace(path)
    assert np.array_equal(recording.raw("cycle"), np.arange(3000) * 3)


def test_a_chunk_that_is_cut_is_refused_not_read_as_something_else(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path) as file:
        place = file["channels/load_angle"].id.get_chunk_info(0)
    with path.open("r+b") as raw:
        raw.seek(place.byte_offset + place.size // 2)
        raw.write(bytes(20))
    with pytest.raises(RecordingError, match="/channels/load_angle rows 0 to 3000 cannot be read"):
        Recording.open(path).raw("load_angle")
