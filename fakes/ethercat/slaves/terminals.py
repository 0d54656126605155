"""Input terminals: one ±10 V channel of 16 bit (the torque sensor) and two PT100 channels.

Their objects follow the modular device profile (ETG.5001): inputs at 0x6000 + 16 a channel, settings at 0x8000 + 16 a
channel. Each channel's TxPDO is a word of status bits and the value.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from fakes.ethercat.objects.common import assignments, common, mapping
from fakes.ethercat.objects.dictionary import Entry, Object, key, sparse_record
from fakes.ethercat.objects.identity import TEMPERATURE_TERMINAL, TORQUE_TERMINAL, Identity
from fakes.ethercat.objects.types import INT, UINT, USINT, Value
from fakes.ethercat.slaves.plant_link import Rows
from fakes.ethercat.slaves.slave import Image, Slave
from fakes.pt100 import ELEMENTS, PRESENTATIONS, convert

PROFILE_MODULAR = 0x00001389
"""0x1000 of a modular device (profile 5001)."""

UNDERRANGE, OVERRANGE, ERROR, INVALID, TOGGLE = 0x0001, 0x0002, 0x0040, 0x4000, 0x8000
"""Status bits beside a value; ``INVALID`` is TxPDO state, ``TOGGLE`` changes with each conversion."""

FULL_SCALE = 32768
"""Counts of the analogue terminal at 10 V."""


def _channel(number: int) -> Object:
    return sparse_record(
        0x6000 + 16 * (number - 1),
        f"Inputs channel {number}",
        {1: Entry("Status", UINT, "ro", 0, "t"), 0x11: Entry("Value", INT, "ro", 0, "t")},
    )


def _tx_mapping(number: int) -> Object:
    index = 0x6000 + 16 * (number - 1)
    return mapping(0x1A00 + number - 1, f"TxPDO channel {number}", ((index, 0x01, 16), (index, 0x11, 16)), "ro")


def _input_assignments(*pdos: int) -> tuple[Object, ...]:
    return assignments((), pdos, "rwpre")


class AnalogInput(Slave):
    """±10 V, 16 bit, one channel, converted every cycle. What lies beyond the range is held at its end and flagged."""

    VOLATILE = ("_toggle", "_status", "_value")

    def __init__(self, role: str, cycle_time_s: float, serial: int = 3) -> None:
        identity = Identity(
            TORQUE_TERMINAL, serial, "AI-10V-16", "Emulated analogue input, 10 V, 16 bit", PROFILE_MODULAR
        )
        objects = (
            *common(identity, round(cycle_time_s * 1e9)),
            _channel(1),
            _tx_mapping(1),
            *_input_assignments(0x1A00),
            sparse_record(0x8000, "Settings channel 1", {2: Entry("Presentation", USINT, "rw", 0, "", 0, 0)}),
            sparse_record(0xF000, "Modular device profile", {1: Entry("Index distance", UINT, "ro", 16)}),
        )
        self._toggle = 0
        self._status = 0
        self._value = 0
        super().__init__(role, identity, objects)
        self.dictionary.readers[key(0x6000, 0x01)] = lambda: self._status
        self.dictionary.readers[key(0x6000, 0x11)] = lambda: self._value

    def report(self, measured: Rows, image: Image | None, first: int, stop: int, cycle: int) -> None:
        """Write conversions of a run that starts at bus cycle ``cycle``."""
        counts = measured["torque_adc"]
        value = np.minimum(np.maximum(counts, -FULL_SCALE), FULL_SCALE - 1)
        status = (np.arange(cycle, cycle + len(counts)) & 1) * TOGGLE
        over, under = value == FULL_SCALE - 1, value == -FULL_SCALE
        if over.any() or under.any():
            status = status | np.where(over, OVERRANGE | ERROR, 0) | np.where(under, UNDERRANGE | ERROR, 0)
        if image is not None and self.inputs.size:
            image["6000:01"][first:stop] = status
            image["6000:11"][first:stop] = value
        self._status, self._value = int(status[-1]), int(value[-1])


class TemperatureInput(Slave):
    """Two PT100 channels, lubricant and surroundings, converted every ``conversion_s`` and held in between."""

    VOLATILE = ("_held",)
    CHANNELS = ("lubricant_temperature", "ambient_temperature")

    def __init__(self, role: str, cycle_time_s: float, conversion_s: float = 0.05, serial: int = 4) -> None:
        identity = Identity(TEMPERATURE_TERMINAL, serial, "RTD-2", "Emulated PT100 input, 2 channels", PROFILE_MODULAR)
        objects = (
            *common(identity, round(cycle_time_s * 1e9)),
            *(_channel(n) for n in (1, 2)),
            *(_tx_mapping(n) for n in (1, 2)),
            *_input_assignments(0x1A00, 0x1A01),
            *(self._settings(n) for n in (1, 2)),
            sparse_record(0xF000, "Modular device profile", {1: Entry("Index distance", UINT, "ro", 16)}),
        )
        self.period = max(1, round(conversion_s / cycle_time_s))
        self._held: npt.NDArray[np.int64] = np.array([[INVALID, 0], [INVALID, 0]])
        super().__init__(role, identity, objects)
        for channel in range(2):
            index = 0x6000 + 16 * channel
            for column, subindex in enumerate((0x01, 0x11)):
                self.dictionary.readers[key(index, subindex)] = self._reader(channel, column)

    def _reader(self, channel: int, column: int) -> Callable[[], Value]:
        return lambda: int(self._held[channel, column])

    @staticmethod
    def _settings(number: int) -> Object:
        return sparse_record(
            0x8000 + 16 * (number - 1),
            f"RTD settings channel {number}",
            {
                0x02: Entry("Presentation", USINT, "rw", 0, "", 0, max(PRESENTATIONS)),
                0x19: Entry("RTD element", UINT, "rw", 0, "", 0, max(ELEMENTS)),
            },
        )

    def report(self, measured: Rows, image: Image | None, first: int, stop: int, cycle: int) -> None:
        """Write held conversions of a run that starts at bus cycle ``cycle``."""
        n = len(measured)
        start = -cycle % self.period
        if start >= n:
            slot = np.zeros(n, dtype=np.int64)
        else:
            slot = np.arange(cycle, cycle + n) // self.period - (cycle - 1) // self.period
        for channel, field in enumerate(self.CHANNELS):
            rows = self._held[channel : channel + 1]
            if start < n:
                fresh = self._convert(channel, measured[field][start :: self.period], (cycle + start) // self.period)
                rows = np.concatenate((rows, fresh))
            if image is not None:
                for column, name in enumerate(_FIELDS[channel]):
                    if name in self.inputs.names:
                        image[name][first:stop] = rows[slot, column]
            self._held[channel] = rows[-1]

    def _convert(self, channel: int, celsius: npt.NDArray[np.float64], conversion: int) -> npt.NDArray[np.int64]:
        """Return rows of (status, value) of new conversions, numbered from ``conversion`` on."""
        settings = 0x8000 + 16 * channel
        rows = convert(celsius, self.dictionary.integer(settings, 0x19), self.dictionary.integer(settings, 0x02))
        rows[:, 0] |= (np.arange(conversion, conversion + len(rows)) & 1) * TOGGLE
        return rows


_FIELDS = (("6000:01", "6000:11"), ("6010:01", "6010:11"))
