"""What a simulation file predicts of recordings, channel by channel, beside what was measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import ConfigurationError, RecordingError
from bench.identification.samples.thermometer import beyond_pt100
from bench.mismatch.criteria import REFERENCE_CELSIUS
from bench.mismatch.prediction import ChannelPrediction, predictions_of
from bench.mismatch.regression.problem import CHANNELS
from bench.recording import Recording, RecordingFolder
from bench.recording.times import not_increasing
from bench.simulation import Simulation
from bench.simulation.frame import FloatArray
from bench.simulation.model import Gearbox
from bench.simulation.terms import CHANNEL_UNITS, TRANSMISSION_ERROR


@dataclass(frozen=True, slots=True)
class Channel:
    """A channel of a recording, SI units, one value a sample: ``measured``, ``simulated``; ``counts``: samples that
    are compared (in motion, no wild ones).
    """

    name: str
    unit: str
    measured: FloatArray
    simulated: FloatArray
    counts: NDArray[np.bool_]

    @property
    def residual(self) -> FloatArray:
        """Measured less simulated (n,)."""
        return np.asarray(self.measured - self.simulated)

    @property
    def rms(self) -> float | None:
        """Root mean square of the residual over the samples that are compared; None where there are none."""
        return _rms(self.residual[self.counts])

    @property
    def rms_of_all(self) -> float | None:
        """The same over all samples, those that are not compared (at rest, turning, wild) as well."""
        return _rms(self.residual)

    @property
    def compared(self) -> float:
        """Share of the samples that are compared."""
        return float(self.counts.mean()) if self.counts.size else 0.0


def _rms(left: FloatArray) -> float | None:
    left = left[np.isfinite(left)]
    return float(np.sqrt(np.mean(left**2))) if left.size else None


@dataclass(frozen=True, slots=True)
class Predicted:
    """A recording with its predicted channels; ``refused``: a sentence for each channel that cannot be predicted;
    ``unlike``: that the simulation is of another gearbox, ``open_circuit``: that the thermometer did not measure, empty
    where it is not so.
    """

    recording: Recording
    channels: tuple[Channel, ...]
    refused: tuple[str, ...]
    unlike: str = ""
    open_circuit: str = ""


def predict_recordings(model: Path, path: Path) -> Iterator[Predicted]:
    """Predict a recording, or all of a folder, from the simulation file ``model``.

    Recordings of the same campaign that lie beside a single one are read, too, if they were made before it: states that
    one recording hands on to the next (a hysteresis, the distance run) go through them.

    Raises
    ------
    ConfigurationError
        The simulation file is wrong, or predicts nothing of any recording.
    RecordingError
        There is no such recording, or it cannot be read.
    """
    gearbox = Simulation.load(model).gearbox  # refused by its own sentence, before recordings are read
    wrong: list[Predicted] = []
    if path.is_dir():
        found = [(r, not_increasing(r.si("time"))) for r in RecordingFolder.open(path).recordings]
        wrong = [Predicted(r, (), (f"{r.recording_id}: time {what}",)) for r, what in found if what]
        recordings: Sequence[Recording] = [r for r, what in found if not what]
        if not recordings:
            raise RecordingError(f"{path}: holds no recording that can be read; see `bench validate` for each file.")
        predictions = predictions_of(model, recordings)
    else:
        recording = Recording.open(path)
        before = [
            r
            for r in RecordingFolder.open(path.resolve().parent).recordings
            if r.campaign_id == recording.campaign_id and r.started_at < recording.started_at
            if not_increasing(r.si("time")) is None
        ]
        predictions = predictions_of(model, [*before, recording], only=len(before))
    yield from wrong
    any_at_all = False
    refused: tuple[str, ...] = ()
    for recording, channels in predictions:
        one = _predicted(model, gearbox, recording, channels)
        any_at_all |= bool(one.channels)
        refused = refused or one.refused
        yield one
    if not any_at_all:
        raise ConfigurationError(f"{model} predicts nothing of {path}: {'; '.join(refused)}.")


def _predicted(
    model: Path, gearbox: Gearbox, recording: Recording, predictions: dict[str, ChannelPrediction]
) -> Predicted:
    channels, refused = [], []
    for name, spec in CHANNELS.items():
        lacking = [source for source in spec.made_of if source not in recording.specs]
        if lacking:
            refused.append(f"{name} is not predicted: {recording.recording_id} has no {', '.join(lacking)}")
        elif name not in predictions:
            refused.append(f"{name} is not predicted: {recording.recording_id} cannot be compared in it")
        elif predictions[name].missing:
            terms = ", ".join(predictions[name].missing)
            refused.append(f"{name} is not predicted: {model.name} has no numbers for {terms}; calibrate it first")
        else:
            prediction = predictions[name]
            unit = _unit(name, recording)
            channels.append(
                Channel(name, unit, measured_channel(recording, name), prediction.values, prediction.counts)
            )
    unlike = gearbox.unlike(float(recording.gearbox.ratio or 1.0))
    return Predicted(recording, tuple(channels), tuple(refused), unlike, _open_circuit(recording))


def _open_circuit(recording: Recording) -> str:
    """That a thermometer was open or shorted, and what stands for the temperature then; empty where it was not."""
    if "temperature" not in recording.specs:
        return ""
    samples = beyond_pt100(recording.si("temperature"))
    if not samples.any():
        return ""
    instead = f"{REFERENCE_CELSIUS:g} °C, for there is no reading" if samples.all() else "the readings before and after"
    return (
        f"{recording.recording_id}: the thermometer is open or shorted in {int(samples.sum())} of {samples.size}"
        f" samples: predicted with {instead}"
    )


def measured_channel(recording: Recording, name: str) -> FloatArray:
    """A compared channel as it was measured (n,), SI; the transmission error in rad (of a linear axis in m)."""
    if name != TRANSMISSION_ERROR:
        return recording.si(name)
    values = recording.read_si(("load_angle", "motor_angle"))
    return np.asarray(values["load_angle"] - values["motor_angle"] / float(recording.gearbox.ratio or 1.0))


def _unit(name: str, recording: Recording) -> str:
    if name == TRANSMISSION_ERROR:
        return "m" if recording.linear else "rad"
    return recording.specs[name].unit or CHANNEL_UNITS[name]
