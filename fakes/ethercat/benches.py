"""Which slaves an emulated bench has: the two drives follow from the plant's motors and encoders."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from fakes.ethercat.bench import EmulatedBench, input_drive_data, load_drive_data
from fakes.plant import Plant

RATED_TORQUE_N_M: dict[float, float] = {52.5: 17.5, 3400.0: 1650.0, 24.0: 8.0, 1000.0: 500.0}
"""Name plates of the motors that ship, by maximum torque; any other motor's rated torque is a third of its maximum."""


def rated_torque_n_m(maximum_torque_n_m: float) -> float:
    """Return a motor's rated torque, to which its drive refers every torque."""
    return RATED_TORQUE_N_M.get(maximum_torque_n_m, maximum_torque_n_m / 3.0)


def bench_of(plant: str | Path, seed: int, cycle_time_s: float, without: Collection[str] = ()) -> EmulatedBench:
    """Return the emulated bench of a plant file: the name of one that ships, or a path.

    ``without`` names terminals the bus has not.

    Raises
    ------
    PlantError : the plant file is missing or wrong.
    """
    made = Plant.from_file(plant, seed, cycle_time_s)
    truth = made.truth
    top_input, top_load = truth.input_motor.maximum_torque, truth.load_motor.maximum_torque
    return EmulatedBench(
        made,
        input_drive_data(truth.input_encoder.bits, rated_torque_n_m(top_input), top_input),
        load_drive_data(truth.load_encoder.bits, rated_torque_n_m(top_load), top_load),
        cycle_time_s,
        without,
    )
