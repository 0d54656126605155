"""What a simulation from elsewhere is given of a recording: its channels, by name, SI, one value a sample.

Speeds, accelerations and loads are given smoothed, as the analysis has them: a count of an encoder at 2 kHz is a speed
of its own. As they were recorded they are there, too: ``recorded/NAME``.
"""

from __future__ import annotations

from collections.abc import Callable

from bench.recording import Recording
from bench.simulation.frame import FloatArray, Frame

RECORDED = "recorded/"
"""begins the name of a channel as it was recorded"""

SMOOTH: dict[str, tuple[str, Callable[[Frame], FloatArray]]] = {
    "motor_velocity": ("rad/s", lambda f: f.omega),
    "motor_acceleration": ("rad/s²", lambda f: f.acceleration),
    "load_acceleration": ("rad/s²", lambda f: f.load_acceleration),
    "load_torque": ("N·m", lambda f: f.torque),
    "load_torque_rate": ("N·m/s", lambda f: f.torque_rate),
    "load_motor_torque": ("N·m", lambda f: f.load_motor_torque),
    "theta": ("rad", lambda f: f.theta),
}
"""derived or smoothed quantities: SI unit and what they are of a frame at the recording's own rate"""


def inputs_of(recording: Recording, frame: Frame) -> dict[str, FloatArray]:
    """Everything that can be given of a recording, (n,) each; ``frame`` is the recording's at its own rate."""
    names = [name for name in recording.channels if name != "time"]
    stored = recording.read_si(["time", *names])
    out = {"time": stored["time"]} | {name: stored[name] for name in names}
    out |= {RECORDED + name: stored[name] for name in names if name in SMOOTH}
    out |= {name: values(frame) for name, (_, values) in SMOOTH.items()}
    return out


def unit_of(name: str, units: dict[str, str]) -> str | None:
    """SI unit of an input; ``units`` are those of the recording's channels. None where it is not known."""
    channel = name.removeprefix(RECORDED)
    return SMOOTH[channel][0] if channel in SMOOTH else units.get(channel)
