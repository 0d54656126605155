"""Polarity at low torque: both motors, both encoders, the torque sensor; and the brakes where there are any."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.commissioning.trial import Tape, Trial
from bench.cycle.assembly import device_errors
from bench.cycle.plugins import DRIVERS, plugin
from bench.errors import DeviceError, LimitError

_HOLD_S = 1.0
_CLOSE = (0.98, 1.02)
_LOAD = (0.7, 1.3)
_STILL_REVOLUTIONS = 0.02


@dataclass(frozen=True, slots=True)
class Ratio:
    """A ratio that is near one where the bench file is right; what is wrong if it is negative, and otherwise."""

    name: str
    value: float
    low: float
    high: float
    negative: str
    other: str

    def check(self) -> None:
        """Raise :class:`DeviceError` with the sentence that fits, if any does."""
        if self.low <= self.value <= self.high:
            return
        reason = self.negative if self.value < 0.0 else self.other
        raise DeviceError(f"{self.name} is {self.value:.3g} where about 1 was expected: {reason}")


def encoders(trial: Trial) -> str:
    """Turn both ways without load: both encoders must follow, and the motor must push the way it turns."""
    ratio, torque = trial.bench.gearbox.ratio, {}
    for sign in (1, -1):
        tape = trial.move(trial.turn(sign * trial.speed, _HOLD_S))
        motor, load = trial.si(tape, "motor_angle"), trial.si(tape, "load_angle")
        cycle = tape.raw("cycle")  # a lost cycle has no row, and took its time all the same
        elapsed = float(cycle[-1] - cycle[0]) * trial.bench.bus.cycle_time
        turned, expected = float(motor[-1] - motor[0]), sign * trial.speed * ratio * elapsed
        Ratio(
            "motor angle over set velocity",
            turned / expected,
            *_CLOSE,
            "the motor's encoder counts against its motor; check its wiring",
            "the motor does not follow; check brake, coupling and the drive's limits",
        ).check()
        Ratio(
            "load angle times ratio over motor angle",
            float(load[-1] - load[0]) * ratio / turned,
            *_CLOSE,
            "polarity of the load drive is the other one",
            "encoder bits or the gearbox' ratio are wrong, or the coupling slips",
        ).check()
        torque[sign] = float(np.mean(trial.si(tape, "motor_torque")))
        trial.values["forward" if sign > 0 else "backward"] = {"turned_rad": turned, "motor_torque_nm": torque[sign]}
    if torque[1] <= torque[-1]:
        raise DeviceError(
            f"the input motor pushes with {torque[1]:.3g} N·m forward and {torque[-1]:.3g} N·m backward, so it seems to"
            " be driven: torque_polarity of the input drive is the other one"
        )
    if not trial.guide.ask("Did the output turn first in the direction you call positive, then back?"):
        raise DeviceError("the output turned the wrong way; polarity of both drives is the other one")
    return "both encoders count alike and the input motor pushes the way it turns"


def torques(trial: Trial) -> str:
    """Put a little load on while turning: sensor, load motor and input motor must all feel it, with the right sign."""
    empty = trial.move(trial.turn(trial.speed, _HOLD_S))
    loaded = trial.move(trial.turn(trial.speed, _HOLD_S, trial.load))

    def change(name: str) -> float:
        return float(np.mean(trial.si(loaded, name)) - np.mean(trial.si(empty, name)))

    ratio, load = trial.bench.gearbox.ratio, trial.load
    found = {name: change(name) for name in ("load_motor_torque", "motor_torque", "load_torque")}
    trial.values.update({"load_nm": load, **found})
    Ratio(
        "load motor torque over its set value",
        found["load_motor_torque"] / load,
        *_LOAD,
        "the load drive reports its torque with the other sign",
        "the load drive does not give the torque that is set; check its limits and rated torque",
    ).check()
    Ratio(
        "input motor torque times ratio over the load",
        found["motor_torque"] * ratio / load,
        0.5,
        2.0,
        "the load helps instead of braking: torque_polarity of the load drive is the other one",
        "no load arrives at the input motor; check couplings and the gearbox' ratio",
    ).check()
    Ratio(
        "torque sensor over load motor",
        found["load_torque"] / load,
        *_LOAD,
        "polarity of the torque sensor is the other one",
        "scale of the torque sensor (rated torque and voltage) is wrong, or its wire is broken",
    ).check()
    _plausible(trial, loaded)
    return f"sensor, load motor and input motor agree on a load of {load:.3g} N·m"


def brakes(trial: Trial) -> str:
    """With the input drive off, push with the load motor: a brake must hold the input shaft."""
    brake = trial.bench.input_motor.brake_torque
    if brake is None:
        return "the bench file knows no brake (input_motor.brake_torque)"
    push = min(trial.load, 0.5 * brake * trial.bench.gearbox.ratio)
    if not trial.guide.ask(f"The load motor pushes with {push:.3g} N·m against the closed brake. Is everybody clear?"):
        raise LimitError("the operator did not want the brake to be tried; nothing was recorded")
    tape = trial.push(push, 0.5)
    angle = trial.si(tape, "motor_angle", steady=False)
    revolutions = float(np.ptp(angle)) / (2.0 * np.pi)
    trial.values.update(push_nm=push, motor_turns=revolutions)
    if revolutions > _STILL_REVOLUTIONS:
        raise DeviceError(
            f"the input motor turned by {revolutions:.3g} turns under {push:.3g} N·m of load with its brake closed; the"
            " brake does not hold"
        )
    return f"the brake of the input motor holds {push:.3g} N·m of load"


def _plausible(trial: Trial, tape: Tape) -> None:
    """Ask the plausibility checks of the torque sensor about the loaded motion."""
    limits = plugin(DRIVERS, "torque_plausibility_limits")(disagreement_nm=0.5 * trial.load)
    monitor = plugin(DRIVERS, "torque_plausibility")(limits, trial.bench.bus.cycle_time)
    torque = trial.si(tape, "load_torque")
    with device_errors():
        findings = monitor.update(
            tape.raw("load_torque"), torque, trial.si(tape, "load_motor_torque"), np.ones(torque.size, np.bool_)
        )
    text = findings.text()
    if text is not None:
        raise DeviceError(str(text))
