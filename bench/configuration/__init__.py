"""The bench as a TOML file: parts, buses, limits, ramps, tuning, calibration, each value with its unit."""

from bench.configuration.loading import BenchFile, load_bench, on_interface, parse_bench, shipped_benches
from bench.configuration.model import BenchConfiguration
from bench.configuration.quantities import UNITS, parse_quantity

__all__ = [
    "UNITS",
    "BenchConfiguration",
    "BenchFile",
    "load_bench",
    "on_interface",
    "parse_bench",
    "parse_quantity",
    "shipped_benches",
]
