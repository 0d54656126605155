"""The table of alarms: for each cause what to do next, and whether the alarm clears itself or is acknowledged.

An alarm that clears itself goes as soon as what it says is over. One that is acknowledged stays until somebody has read
it, and until then the bench gets no torque.
"""

from __future__ import annotations

from dataclasses import dataclass

_THEN = "Then acknowledge, reset the bench, and go on where it stopped."
_FIND = f"Find the reason. {_THEN}"
_LOOK = (
    "Nobody has looked whether the shafts stand still: the drives' watchdogs should have stopped them. Look there;"
    " if anything turns, use the emergency stop. "
)


@dataclass(frozen=True, slots=True)
class Kind:
    """What is known of a cause.

    Attributes
    ----------
    next_act : what to do next, in the order in which it is done.
    clears_itself : whether the service takes the alarm away when what it says is over.
    """

    next_act: str
    clears_itself: bool = False


KINDS: dict[str, Kind] = {
    # limits
    "MOTOR_SPEED": Kind(f"Look whether the input drive's tuning or the point's speed is wrong. {_THEN}"),
    "MOTOR_TORQUE": Kind(f"Look whether something is stuck or the load is too great. {_THEN}"),
    "LOAD_TORQUE": Kind(f"Look at the coupling and at the torque sensor. {_THEN}"),
    "LOAD_MOTOR_TORQUE": Kind(f"Look at the coupling and at the load drive. {_THEN}"),
    "TEMPERATURE_HIGH": Kind(f"Let the gearbox cool down, look at the oil level. {_THEN}"),
    "TEMPERATURE_LOW": Kind(f"Warm up the room, or look at the thermometer. {_THEN}"),
    "TEMPERATURE_RATE": Kind(f"No lubricant warms that fast: look at the thermometer's plug and cable. {_THEN}"),
    "LOAD_POSITION": Kind(f"Turn the load side back by hand with the drives off, or choose a shorter motion. {_THEN}"),
    "VELOCITY_ERROR": Kind(f"The input motor does not follow: look for something stuck, and at the drive. {_THEN}"),
    "TORQUE_DISAGREEMENT": Kind(
        f"Sensor and load motor do not agree: look at the sensor's cable and the coupling's bolts. {_THEN}"
    ),
    "ENCODER_DISAGREEMENT": Kind(f"The two encoders do not agree: look at couplings and encoder cables. {_THEN}"),
    "LOAD_SPEED": Kind(f"The load side turned too fast: look at the coupling and at the point's speed. {_THEN}"),
    "MOTOR_ACCELERATION": Kind(
        f"The input motor was thrown: look for play, a shaft that slipped, and the drive's tuning. {_THEN}"
    ),
    "LOAD_TORQUE_RATE": Kind(
        f"The load torque jumped: check the coupling, and whether something hit the load. {_THEN}"
    ),
    "FOLLOWING_ERROR": Kind(f"The load side does not follow the motor: look at couplings and gearbox. {_THEN}"),
    "TORQUE_ERROR": Kind(f"The load drive does not give its torque: look at the drive and the coupling. {_THEN}"),
    "TORQUE_DRIFT": Kind(f"The torque sensor drifts: look at its cable and mounting, let it warm up. {_THEN}"),
    "FRICTION": Kind(f"The gearbox turns too hard or too easily: look at the oil and for something stuck. {_THEN}"),
    # sensors and bus
    "MOTOR_ENCODER_FROZEN": Kind(
        f"The motor encoder gives no new values: look at its cable and at the input drive. {_THEN}"
    ),
    "LOAD_ENCODER_FROZEN": Kind(
        f"The load encoder gives no new values: look at its cable and at the load drive. {_THEN}"
    ),
    "TORQUE_SENSOR_FROZEN": Kind(
        f"The torque sensor gives no new values: look at its cable, supply and terminal. {_THEN}"
    ),
    "TORQUE_SENSOR_RANGE": Kind(
        f"The torque sensor is beyond its range or broken: look at its cable before loading again. {_THEN}"
    ),
    "TEMPERATURE_SENSOR": Kind(f"The thermometer is open or short-circuited: look at its plug and cable. {_THEN}"),
    "TEMPERATURE_AGE": Kind(
        f"The thermometer gives no new values: look at its cable and at the device that reads it. {_THEN}"
    ),
    "MOTOR_VELOCITY_FROZEN": Kind(f"The input drive gives no new speeds: look at the drive and its encoder. {_THEN}"),
    "LOAD_VELOCITY_FROZEN": Kind(f"The load drive gives no new speeds: look at the drive and its encoder. {_THEN}"),
    "MOTOR_TORQUE_FROZEN": Kind(f"The input drive gives no new torques: look at the drive. {_THEN}"),
    "LOAD_MOTOR_TORQUE_FROZEN": Kind(f"The load drive gives no new torques: look at the drive. {_THEN}"),
    "TEMPERATURE_FROZEN": Kind(f"The thermometer repeats one value: look at its cable and its device. {_THEN}"),
    "RECORDER": Kind(f"The recording could not be kept up: look at the disk, its room and what else uses it. {_THEN}"),
    "LOST_CYCLES": Kind(f"The bus lost cycles: look at network plugs and at what else this computer does. {_THEN}"),
    "LOST_SHARE": Kind(f"The bus lost many cycles: look at network plugs and at what else this computer does. {_THEN}"),
    "BUS_STOPPED": Kind(f"The computer did not keep pace, or a program ended: look at what else it does. {_THEN}"),
    "BUS_ENDED": Kind(f"The program that sends the frames is gone. {_LOOK}{_THEN}"),
    "PROGRAM": Kind(f"Show it to whoever wrote the sequence or looks after the software. {_THEN}"),
    # drives and safety circuits
    "INPUT_DRIVE_FAULT": Kind(f"Read the input drive's display and take the reason away. {_THEN}"),
    "LOAD_DRIVE_FAULT": Kind(f"Read the load drive's display and take the reason away. {_THEN}"),
    "EMERGENCY_STOP": Kind(f"Whoever pressed it knows why. With all clear, release it. {_THEN}"),
    "SAFE_TORQUE_OFF": Kind(f"The drives were taken their torque: look at guards and safety relay. {_THEN}"),
    # ends of a run or of its beginning
    "OPERATOR": Kind("Look whether all is well at the bench. Then go on where it stopped."),
    "RESET": Kind("Take the cause away that is named, acknowledge, then reset the bench again."),
    "DeviceError": Kind(
        "Look at power, network cable and emergency stop of the bench. Then acknowledge and start again."
    ),
    "LimitError": Kind(
        "Change the campaign, or the limit if it is wrong; where room on the disk is short, make room. Then acknowledge"
        " and go on."
    ),
    "ConfigurationError": Kind("Correct the file that is named. Then acknowledge and start again."),
    "KILLED": Kind(f"{_LOOK}Then acknowledge; recordings are kept."),
    "DIED": Kind(f"{_LOOK}Then acknowledge, and go on where it stopped: what was recorded is kept."),
    "LAUNCHER": Kind("The run was not started. Take the cause away that is named, acknowledge, and start again."),
    # of the service itself: over when it is over
    "DISK": Kind("Move old recordings to the backup, see Storage. Finished points are not repeated.", True),
    "STATE_FOLDER": Kind(
        "STOP works all the same. Make room on the disk or mend its rights: until then nothing new begins, and what the"
        " book says may be lost if the service ends.",
        True,
    ),
    "SILENT": Kind("The bench may still move. Press STOP; if it does not come to rest, use the emergency stop.", True),
    "KEEPER": Kind(
        "STOP works all the same. The run goes on without being watched: if this stays, press STOP and start bench"
        " serve again.",
        True,
    ),
    "TWIN": Kind(
        "Compare before and since, as soon as there are enough recordings since the one named; bench mismatch on those"
        " names it properly. Then acknowledge; pause or stop the run if what it measures is worth nothing any more."
    ),
    "TWIN_ENDED": Kind("The run goes on. Look at the model; the next run with one is watched again.", True),
    "STATE_FILE": Kind("Look at the file that was put aside. Acknowledge when what was waiting is known again."),
}
"""What to do, by the cause a run ends with or the service sees."""

OTHERWISE = Kind("Note what happened and show it to whoever looks after the software. What was recorded is kept.")


def kind_of(cause: str) -> Kind:
    """Return what is known of a cause; one without an entry is acknowledged."""
    return KINDS.get(cause, OTHERWISE)
