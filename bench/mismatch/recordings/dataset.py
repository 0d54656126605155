"""A folder of recordings as rows to compare: reduced, and split by operating point."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.recordings.output_orders import OutputSpectrum
from bench.mismatch.recordings.pieces import WELL_CUT_S, Piece, counted
from bench.mismatch.recordings.prepared import Folder
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.recordings.vibration import Density, ShaftSpectrum
from bench.recording import Recording
from bench.recording.header import Gearbox
from bench.simulation.quantities import AUXILIARY

AT_ONE_POINT = ("constant_velocity", "reversal", "dwell")
"""kinds of recordings that show one speed and one load each"""


@dataclass(frozen=True, slots=True)
class Member:
    """One recording of the data set, or a block of one."""

    index: int
    recording: Recording
    point: tuple[str, float, float, float]
    held_out: bool
    fold: int
    name: str


@dataclass(slots=True)
class Dataset:
    """Recordings of a folder, reduced. ``rows[channel]`` holds rows of all recordings, in order."""

    members: list[Member]
    rejected: list[tuple[str, str]]
    folder: Folder
    rows: dict[str, Rows] = field(default_factory=dict)
    density: dict[str, list[Density]] = field(default_factory=dict)
    unsteady: dict[str, list[Density]] = field(default_factory=dict)
    """of recordings without a steady part: their longest run in motion"""
    shaft: list[ShaftSpectrum] = field(default_factory=list)
    output: dict[str, list[OutputSpectrum]] = field(default_factory=dict)
    swing: dict[int, float] = field(default_factory=dict)
    """mean square of the load torque's rate in a recording, (N·m/s)², by its index"""
    notes: list[str] = field(default_factory=list)
    parts: list[Piece] = field(default_factory=list)
    travelled: dict[str, float] = field(default_factory=dict)
    """distance run before each recording in this campaign, rad at the output, by the recording's path"""
    simulated: frozenset[str] = frozenset()
    """channels that a simulation from elsewhere predicts; they hold what it leaves"""
    unresolved: float = 0.0
    """what rounding leaves of the load motor's reported torque where the load is kept, N·m"""

    @property
    def gearbox(self) -> Gearbox:
        """Gearbox of the recordings, as their headers have it."""
        return self.members[0].recording.gearbox

    @property
    def ratio(self) -> float:
        """Gear ratio u of the recordings."""
        return float(self.members[0].recording.gearbox.ratio or 1.0)

    @property
    def linear(self) -> bool:
        """Whether the recordings are of a linear axis, whose motor_angle is a length."""
        return is_linear(self.members[0].recording)

    @property
    def cut(self) -> bool:
        """Whether recordings are pieces of a few longer ones: then a sensor's zero is not each piece's own."""
        whole = {m.recording.imported_from or str(m.recording.path) for m in self.members}
        return len(whole) < len(self.members)

    @property
    def auxiliary_units(self) -> dict[str, str]:
        """Units of the quantities that are no channels of the bench, by name without ``aux/``."""
        named = [(name, spec.unit) for m in self.members for name, spec in m.recording.specs.items()]
        return {name.removeprefix(AUXILIARY): unit for name, unit in named if name.startswith(AUXILIARY)}

    @property
    def present(self) -> frozenset[str]:
        """Channels that some recording has."""
        return frozenset(name for m in self.members for name in m.recording.channels)

    def held_out(self) -> set[int]:
        """Indices of the recordings that are scored and never fitted."""
        return {m.index for m in self.members if m.held_out}

    def folds(self) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
        """Fold of each recording by its index; -1 for those held out or not there."""
        size = max(m.index for m in self.members) + 1
        out = np.full(size, -1, dtype=np.int64)
        for m in self.members:
            out[m.index] = m.fold
        return out

    def name(self, index: int) -> str:
        """Name of a recording by its index."""
        return next(m.name for m in self.members if m.index == index)


def is_linear(recording: Recording) -> bool:
    """Whether a recording is of a linear axis."""
    return "motor_angle" in recording.specs and recording.specs["motor_angle"].unit == "m"


def enough(data: Dataset) -> str:
    """Why a data set is too small to tell noise from structure; empty where it is not."""
    least = criteria.FEWEST_RECORDINGS
    train = sum(not m.held_out for m in data.members)
    if train < least:
        return f"{_kept(data, train)}, at least {least} are needed to distinguish noise from structure"
    points = {m.point[1:3] for m in data.members}
    if all(m.recording.kind in AT_ONE_POINT for m in data.members) and len(points) < least:
        return (
            f"{len(points)} operating points were run, at least {least} are needed to distinguish noise from structure"
        )
    return ""


def _kept(data: Dataset, train: int) -> str:
    """What can be fitted, in words: recordings, or blocks of few that are too short."""
    if all(piece.rows is None for piece in data.parts):
        return f"{counted(train)} can be fitted"
    whole = {str(piece.recording.path): piece.recording for piece in data.parts}.values()
    seconds = sum(r.size / r.sample_rate for r in whole)
    return (
        f"{seconds:.3g} s of recordings make {train} blocks that can be fitted ({WELL_CUT_S:g} s make enough;"
        " `pieces` in the mapping of an import cuts shorter ones)"
    )
