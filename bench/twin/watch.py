"""Watching a campaign: calibrate on the first recordings, then test after each whether the model still holds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bench.errors import RecordingError
from bench.recording import Recording
from bench.twin.evidence import Evidence, combined_log
from bench.twin.predicting import Look, Predicting, Sketch
from bench.twin.scale import ALPHA_TEST, CALIBRATION, Scale, scales
from bench.twin.streams import AT_ONE_POINT, Stream, streams

LIMIT = math.log(1.0 / ALPHA_TEST)
"""log of the evidence at which the model no longer holds"""


@dataclass(frozen=True, slots=True)
class Seen:
    """One recording at one point as the twin saw it; ``innovations`` in scales, empty while it calibrates."""

    recording: Recording
    values: Mapping[Stream, float]
    innovations: Mapping[Stream, float] = field(default_factory=dict)
    evidence: float = 0.0
    """log of the evidence against the model, all streams together, after this recording"""
    left: Mapping[str, Sketch] = field(default_factory=dict)
    """by channel what the model left of it, coarsely"""


@dataclass(slots=True)
class Watch:
    """A campaign under watch.

    ``seen``: recordings at one point in their order; the first ``CALIBRATION`` calibrate. ``alarmed``: index in
    ``seen`` of the recording after which the model no longer held; it stays, whatever comes. ``unread``: recordings
    that could not be looked at, and why.
    """

    model: Path
    seen: list[Seen] = field(default_factory=list)
    evidence: dict[Stream, Evidence] = field(default_factory=dict)
    scales: dict[Stream, Scale] = field(default_factory=dict)
    weights: dict[Stream, float] = field(default_factory=dict)
    alarmed: int | None = None
    unread: dict[str, str] = field(default_factory=dict)
    _waiting: list[Recording] = field(default_factory=list)
    _predicting: Predicting | None = None

    @property
    def calibrated(self) -> bool:
        """Whether the test has begun."""
        return bool(self.scales)

    @property
    def tested(self) -> int:
        """How many recordings were tested."""
        return max(0, len(self.seen) - CALIBRATION)

    @property
    def points(self) -> int:
        """How many recordings at one point there were, those that wait for the calibration included."""
        return len(self.seen) + sum(r.kind in AT_ONE_POINT for r in self._waiting)

    @property
    def without(self) -> Mapping[str, str]:
        """Channels that cannot be watched, and why."""
        return {} if self._predicting is None else self._predicting.without

    def add(self, recording: Recording) -> bool:
        """Look at the next finished recording; True where the model no longer holds since just now.

        Raises ConfigurationError where the model's file is wrong.
        """
        if self._predicting is None:
            self._waiting.append(recording)
            if sum(r.kind in AT_ONE_POINT for r in self._waiting) < CALIBRATION:
                return False
            self._predicting = Predicting(self.model, self._waiting)
            waiting, self._waiting = self._waiting, []
            for earlier in waiting:
                self._look(earlier)
            return False
        return self._look(recording)

    def _look(self, recording: Recording) -> bool:
        assert self._predicting is not None
        try:
            look = self._predicting.look(recording)
        except (RecordingError, OSError, ValueError) as error:
            self.unread[recording.recording_id] = str(error)
            return False
        if recording.kind not in AT_ONE_POINT:
            return False
        if not self.calibrated:
            self.seen.append(Seen(recording, look.values, left=look.left))
            if len(self.seen) >= CALIBRATION:
                self._calibrate()
            return False
        return self._test(recording, look)

    def _calibrate(self) -> None:
        assert self._predicting is not None
        every = streams({s.channel for seen in self.seen for s in seen.values}, self._predicting.orders)
        self.scales = scales([seen.values for seen in self.seen], list(every))
        total = sum(every[stream] for stream in self.scales)
        self.weights = {stream: every[stream] / total for stream in self.scales}
        self.evidence = {stream: Evidence(stream.signed) for stream in self.scales}

    def _test(self, recording: Recording, look: Look) -> bool:
        number = self.tested + 1
        each = {stream: scale.innovation(look.values) for stream, scale in self.scales.items()}
        innovations = {stream: z for stream, z in each.items() if z is not None}
        for stream, z in innovations.items():
            self.evidence[stream].add(z, number)
        weights = np.array([self.weights[s] for s in self.evidence])
        log = combined_log(np.array([e.log for e in self.evidence.values()]), weights)
        self.seen.append(Seen(recording, look.values, innovations, log, look.left))
        if self.alarmed is None and log >= LIMIT:
            self.alarmed = len(self.seen) - 1
            return True
        return False
