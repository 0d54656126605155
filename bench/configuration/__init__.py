"""The bench as a TOML file: parts, buses, limits, ramps, tuning, calibration, each value with its unit."""

from bench.configuration.loading import (
    BenchFile,
    concealing,
    load_bench,
    on_interface,
    parse_bench,
    playing,
    shipped_benches,
)
from bench.configuration.model import BenchConfiguration
from bench.configuration.quantities import UNITS, parse_quantity

__all__ = [
    "UNITS",
    "BenchConfiguration",
    "BenchFile",
    "concealing",
    "load_bench",
    "on_interface",
    "parse_bench",
    "parse_quantity",
    "playing",
    "shipped_benches",
]
