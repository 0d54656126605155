"""Errors a user can do something about: one sentence saying what is wrong, where, and what would be right."""

from __future__ import annotations

import traceback
from pathlib import Path

_LONGEST = 300


class BenchError(Exception):
    """Base of every error that is shown to the user as one sentence, without a traceback."""


class RecordingError(BenchError):
    """A recording that does not meet the recording format, or that an analysis cannot use."""


class BacklogError(RecordingError):
    """The disk has not kept up with a recording that may wait for nothing: the recording ends, not the bench."""


class ConfigurationError(BenchError):
    """A bench, campaign, plant or simulation file with a wrong key or value."""


class LimitError(BenchError):
    """A plan or a set value that would break a limit of the bench."""


class DeviceError(BenchError):
    """A device that is missing, of the wrong identity, faulty or silent."""


class ProofError(BenchError):
    """An examination without its examiner, or a folder of it that is not what it should be."""


def one_sentence(error: BaseException) -> str:
    """Return what went wrong as one line: an error for users as it stands, any other with its kind and its place."""
    if isinstance(error, BenchError):
        return " ".join(str(error).split())
    said = " ".join(str(error).split())[:_LONGEST]
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}{f': {said}' if said else ''}{place}"
