"""Recordings: the HDF5 contract of the recording format 1.0, written, read, validated, repaired, exported."""

from bench.recording.file.channel_names import AUXILIARY, RESIDUAL, SIMULATED
from bench.recording.folder import RecordingFolder, Rejected
from bench.recording.header import ChannelSpec, Event, Gearbox, RecordingHeader, Segment, Setpoint
from bench.recording.one_shot import write_recording
from bench.recording.reader import Recording
from bench.recording.writing.writer import FAST_CHUNK_ROWS, RecordingWriter

__all__ = [
    "AUXILIARY",
    "FAST_CHUNK_ROWS",
    "RESIDUAL",
    "SIMULATED",
    "ChannelSpec",
    "Event",
    "Gearbox",
    "Recording",
    "RecordingFolder",
    "RecordingHeader",
    "RecordingWriter",
    "Rejected",
    "Segment",
    "Setpoint",
    "write_recording",
]
