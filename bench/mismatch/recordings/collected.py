"""Rows and spectra of recordings, by channel, as they are reduced one after another."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.output_orders import OutputSpectrum, output_spectra
from bench.mismatch.recordings.prepared import Prepared
from bench.mismatch.recordings.rows import Rows, angle_rows, heat_rows, join, slow_rows
from bench.mismatch.recordings.swing import swing
from bench.mismatch.recordings.vibration import Density, ShaftSpectrum, density, shaft_spectrum
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR


@dataclass(slots=True)
class Collected:
    """Rows and spectra of the recordings read so far, by channel."""

    rows: dict[str, list[Rows]] = field(default_factory=dict)
    aside: dict[str, list[Rows]] = field(default_factory=dict)
    """of recordings in which the channel is not compared, through which its states go on"""
    density: dict[str, list[Density]] = field(default_factory=dict)
    unsteady: dict[str, list[Density]] = field(default_factory=dict)
    """of recordings without a steady part, such as heating runs: their longest run in motion"""
    shaft: list[ShaftSpectrum] = field(default_factory=list)
    output: dict[str, list[OutputSpectrum]] = field(default_factory=dict)
    swing: dict[int, float] = field(default_factory=dict)
    """mean square of the load torque's rate in each recording, (N·m/s)²"""

    def add(self, prepared: Prepared, channels: frozenset[str], manner: Manner) -> None:
        """Reduce a recording in the channels in which it can be compared."""
        for channel in sorted(channels & set(prepared.measured)):
            if channel == TEMPERATURE:
                self.rows.setdefault(channel, []).append(heat_rows(prepared))
                continue
            if channel == TRANSMISSION_ERROR:
                if prepared.kind == "heating":  # the series does not hold at heating speed: only states go on there
                    self.aside.setdefault(channel, []).append(slow_rows(prepared, channel, manner))
                else:
                    self.rows.setdefault(channel, []).append(angle_rows(prepared))
            else:
                self.rows.setdefault(channel, []).append(slow_rows(prepared, channel, manner))
            spectrum = density(prepared, channel)
            if spectrum is not None:
                self.density.setdefault(channel, []).append(spectrum)
            elif (moving := density(prepared, channel, steady=False)) is not None:
                self.unsteady.setdefault(channel, []).append(moving)
            self.output.setdefault(channel, []).extend(
                output_spectra(prepared, channel) if channel in (MOTOR_TORQUE, LOAD_TORQUE) else ()
            )
            if channel == LOAD_TORQUE:
                self.swing[int(prepared.frame.recording[0])] = swing(prepared)
            if channel == MOTOR_TORQUE:
                shaft = shaft_spectrum(prepared)
                if shaft is not None:
                    self.shaft.append(shaft)

    def travelled_before(self, distance: float) -> None:
        """Count the distance run before these recordings, rad at the output."""
        for rows in (*self.rows.values(), *self.aside.values()):
            rows[:] = [replace(r, frame=replace(r.frame, travel=r.frame.travel + distance)) for r in rows]

    def take(self, other: Collected) -> None:
        """Append the rows of further recordings."""
        for channel, rows in other.rows.items():
            self.rows.setdefault(channel, []).extend(rows)
        for channel, rows in other.aside.items():
            self.aside.setdefault(channel, []).extend(rows)
        for channel, densities in other.density.items():
            self.density.setdefault(channel, []).extend(densities)
        for channel, moving in other.unsteady.items():
            self.unsteady.setdefault(channel, []).extend(moving)
        for channel, spectra in other.output.items():
            self.output.setdefault(channel, []).extend(spectra)
        self.shaft += other.shaft
        self.swing |= other.swing

    def joined(self, channel: str) -> Rows:
        """All rows of a channel, with the frame of those aside."""
        out, aside = join(self.rows[channel]), self.aside.get(channel)
        return replace(out, frame=replace(out.frame, aside=join(aside).frame)) if aside else out
