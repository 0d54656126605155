"""One gearbox, measured in spring, summer, and after its seal was changed; and another one that nobody identified."""

from __future__ import annotations

import dataclasses
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from bench.archive import Index
from bench.simulation import TERM_COUNT, FourierSet, Parameter, Simulation, Term, TransmissionErrorModel
from bench.trend import Value, kept
from tests.bench.recording.builders import write

GEARBOX = "RH-7"
STIFFNESS = 3.2e6
"""N·m/rad"""
ORDERS = (1.0, 3.0, 46.0)
AMPLITUDES = (3e-5, 1e-5, 2e-5)
STD = 1e-7
LEAST, MOST = (-1000.0, 4.0, 27.0), (1000.0, 12.0, 36.0)
"""N·m, °/s, °C that were measured"""


def fourier(lift: float = 0.0) -> FourierSet:
    """Constant amplitudes, a compliance, the mean error ``lift``; all with standard deviations."""
    made = FourierSet.zeros(ORDERS)
    amplitude, offset = made.amplitude.copy(), made.offset.copy()
    amplitude[:, TERM_COUNT - 1] = AMPLITUDES
    offset[TERM_COUNT - 1], offset[3] = lift, -1.0 / STIFFNESS
    covariance = np.zeros((len(ORDERS), 2 * TERM_COUNT, 2 * TERM_COUNT))
    covariance[:, TERM_COUNT - 1, TERM_COUNT - 1] = STD**2
    offset_covariance = np.zeros((TERM_COUNT, TERM_COUNT))
    offset_covariance[TERM_COUNT - 1, TERM_COUNT - 1], offset_covariance[3, 3] = STD**2, (0.001 / STIFFNESS) ** 2
    return dataclasses.replace(
        made, amplitude=amplitude, offset=offset, covariance=covariance, offset_covariance=offset_covariance
    )


def identified(folder: str, friction: float = 0.6, shift: float = 0.0) -> kept.Identified:
    """A campaign: friction at 5 °/s and 30 °C in N·m; every amplitude of the positive direction moved by ``shift``."""
    model = Simulation.nominal().with_transmission_error(TransmissionErrorModel(fourier(4e-6), fourier(-4e-6)))
    model = model.with_term(Term("thermal.convection", parameters={"R": Parameter(0.05, "K/W", 0.001)}))
    positive = fourier(4e-6)
    moved = positive.amplitude.copy()
    moved[:, TERM_COUNT - 1] += shift
    model = model.with_transmission_error(
        TransmissionErrorModel(dataclasses.replace(positive, amplitude=moved), fourier(-4e-6))
    )
    limits = (LEAST, MOST)
    return kept.Identified(
        folder,
        model,
        "",
        {"positive": limits, "negative": limits},
        {"positive": Value(1.7e-6, 2e-9, 17.0)},
        {(5.0, 30.0): Value(friction, 1e-3, 9.0), (10.0, 30.0): Value(friction + 0.1, 1e-3, 9.0)},
    )


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Three campaigns of one gearbox, identified; in the last, friction is a tenth more. One of another."""
    root = tmp_path / "recordings"
    for month, serial, friction in ((3, GEARBOX, 0.6), (6, GEARBOX, 0.6), (9, GEARBOX, 0.66), (10, "RH-9", None)):
        folder = root / f"month-{month}"
        folder.mkdir(parents=True)
        begun = datetime(2026, month, 5, 8, tzinfo=UTC)
        write(folder / "r001.h5", rows=60, gearbox_serial=serial, started_at=begun, campaign_id=folder.name)
        if friction is not None:
            kept.store(identified(folder.name, friction), folder, kept.stamp_of(folder))
    return root


@pytest.fixture
def index(root: Path) -> Index:
    made = Index(root, root / ".archive.sqlite")
    made.refresh()
    return made
