"""The emulated plant: time-domain dynamics of the whole bench, compiled, with its truth in files of its own."""

from fakes.plant.errors import PlantError
from fakes.plant.faults import FAULTS, Fault, FaultTable
from fakes.plant.images import COMMAND_DTYPE, MEASUREMENT_DTYPE, MODE_TORQUE, MODE_VELOCITY
from fakes.plant.plant import Plant, Snapshot
from fakes.plant.plant_file import read_plant, shipped_plants
from fakes.plant.truth import PlantTruth

__all__ = [
    "COMMAND_DTYPE",
    "FAULTS",
    "MEASUREMENT_DTYPE",
    "MODE_TORQUE",
    "MODE_VELOCITY",
    "Fault",
    "FaultTable",
    "Plant",
    "PlantError",
    "PlantTruth",
    "Snapshot",
    "read_plant",
    "shipped_plants",
]
