"""Recordings: the HDF5 contract of the recording format 1.0, written, read, validated, repaired, imported, exported."""

from bench.recording.folder import RecordingFolder, Rejected
from bench.recording.header import ChannelSpec, Event, Gearbox, RecordingHeader, Segment, Setpoint
from bench.recording.one_shot import write_recording
from bench.recording.reader import Recording

__all__ = [
    "ChannelSpec",
    "Event",
    "Gearbox",
    "Recording",
    "RecordingFolder",
    "RecordingHeader",
    "Rejected",
    "Segment",
    "Setpoint",
    "write_recording",
]
