"""In which channels a recording can be compared: it must have what the simulation needs there, and the campaign's zero.

A recording without torque sensor in a campaign that has one would be read as unloaded; angles of another encoder zero
turn every phase. Both are left out of the channels concerned, and the report's notes say so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bench.recording import Recording

# channel -> what it is made of, and what the simulation of it needs where the campaign has it
INPUTS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "transmission_error": (("motor_angle", "load_angle"), ("load_torque", "temperature")),
    "motor_torque": (("motor_torque", "motor_angle"), ("load_torque", "temperature")),
    "temperature": (("temperature", "motor_torque", "motor_angle"), ("load_torque",)),
    "load_torque": (("load_torque", "load_motor_torque"), ("motor_angle",)),
}


@dataclass(frozen=True, slots=True)
class Comparable:
    """What a folder's recordings have, and the encoder zero that most of them share."""

    present: frozenset[str]
    zero: str | None

    @classmethod
    def of(cls, recordings: Sequence[Recording], notes: list[str]) -> Comparable:
        """Look through the recordings; what is left out is listed in ``notes``."""
        present = frozenset(name for r in recordings for name in r.channels)
        zeros = [r.zero_id for r in recordings]
        usual = max(dict.fromkeys(zeros), key=zeros.count)
        out = cls(present, usual)
        if len(set(zeros)) > 1:
            others = sum(zero != usual for zero in zeros)
            notes.append(
                f"recordings of {len(set(zeros))} encoder zeros are mixed: the transmission error is compared on those "
                f"of zero {usual or 'unknown'} only, {others} of {len(zeros)} recordings are left out there, nothing "
                "said of output angles in the torques holds for them"
            )
        for channel, (_, inputs) in INPUTS.items():
            lacking = [r.recording_id for r in recordings if out._lacks(r, channel)]
            if lacking and len(lacking) < len(recordings):
                named = ", ".join(lacking[:3]) + (" and others" if len(lacking) > 3 else "")
                needs = " or ".join(name for name in inputs if name in present)
                notes.append(f"{len(lacking)} recordings ({named}) have no {needs}: not compared in {channel}")
        return out

    def _lacks(self, recording: Recording, channel: str) -> bool:
        made_of, inputs = INPUTS[channel]
        if not all(name in recording for name in made_of):
            return False
        return not all(name in recording for name in inputs if name in self.present)

    def channels(self, recording: Recording, dead: frozenset[str] = frozenset()) -> frozenset[str]:
        """Channels a recording is compared in, if those in ``dead`` hold no number."""
        out = set()
        for channel, (made_of, inputs) in INPUTS.items():
            if dead & {*made_of, *(name for name in inputs if name in self.present)}:
                continue
            other_zero = channel == "transmission_error" and recording.zero_id != self.zero
            if all(name in recording for name in made_of) and not self._lacks(recording, channel) and not other_zero:
                out.add(channel)
        return frozenset(out)
