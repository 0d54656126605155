"""Which reader a file needs: by its first bytes, never by its name."""

from __future__ import annotations

from os import SEEK_END
from pathlib import Path

from bench.errors import RecordingError
from bench.importing.formats.hdf5 import Hdf5Source
from bench.importing.formats.json_file import JsonSource, is_json
from bench.importing.formats.matlab import MatlabSource, is_version_4
from bench.importing.formats.mdf import MdfSource
from bench.importing.formats.numpy_file import SIGNATURE as NUMPY_SIGNATURE
from bench.importing.formats.numpy_file import NumpySource, is_archive
from bench.importing.formats.parquet import ParquetSource
from bench.importing.formats.source import Source
from bench.importing.formats.tdms import TdmsSource
from bench.importing.formats.text import TextSource
from bench.importing.formats.text_layout import TextOptions

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_MAT73_USER_BLOCK = 512
_HEAD = 4096
_SHEETS = (".xls", ".xlsx", ".xlsm", ".ods")
_UTF16 = (b"\xff\xfe", b"\xfe\xff")


def open_source(path: Path, options: TextOptions | None = None) -> Source:
    """Open a file of measurements.

    Raises
    ------
    RecordingError
        The file is missing, empty, damaged, or of a kind that is not known.
    """
    if path.is_dir():
        raise RecordingError(f"{path}: is a folder, it should be one file of measurements.")
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD)
            size = file.seek(0, SEEK_END)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror}).") from error
    if not head:
        raise RecordingError(f"{path}: is empty, it should hold measurements.")
    if head.startswith(_HDF5_SIGNATURE) or head[_MAT73_USER_BLOCK:].startswith(_HDF5_SIGNATURE):
        return Hdf5Source(path, transposed=head.startswith(b"MATLAB"))
    if head.startswith(b"MATLAB 5.0") or is_version_4(head, size):
        return MatlabSource(path)
    if head.startswith((b"TDSm", b"TDSh")):
        return TdmsSource(path)
    if head.startswith(b"PAR1"):
        return ParquetSource(path)
    if head.startswith((b"MDF     ", b"UnFinMF ")):
        return MdfSource(path)
    if head.startswith(NUMPY_SIGNATURE) or is_archive(path, head):
        return NumpySource(path)
    if is_json(head):
        return JsonSource(path)
    if head.startswith(_UTF16) or b"\0" not in head:
        return TextSource(path, options or TextOptions())
    if path.suffix.lower() in _SHEETS:
        raise RecordingError(f"{path}: is a spreadsheet; each of its sheets should be saved as CSV.")
    raise RecordingError(
        f"{path}: is none of MAT, HDF5, TDMS, Parquet, MDF, NumPy, JSON or text (CSV of any separator); it should be "
        "one of them."
    )
