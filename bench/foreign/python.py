"""A Python function from a recording to predicted channels, ``module:name``.

It gets an :class:`xarray.Dataset` of the recording over ``time`` (SI; inputs as :mod:`bench.foreign.inputs` has them)
and returns a dataset, or a mapping, of predicted channels. Keyword arguments with a number as default may be
recalibrated: ``def joint(recording, f_c=0.4)``.
"""

from __future__ import annotations

import importlib
import inspect
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.errors import ConfigurationError
from bench.foreign.base import Channels, Free, Values
from bench.simulation.frame import FloatArray


@dataclass(frozen=True, slots=True)
class Function:
    """A function by its name; it is looked up in each process anew."""

    source: str
    kind: str = "python"

    def run(self, inputs: Mapping[str, FloatArray], values: Values) -> Channels:
        """Call the function. Raises ConfigurationError for whatever it raises."""
        import xarray

        data = xarray.Dataset(
            {name: ("time", array) for name, array in inputs.items() if name != "time"}, {"time": inputs["time"]}
        )
        function = look_up(self.source)
        try:
            result = function(data, **values)
            return {str(name): np.asarray(result[name], dtype=np.float64) for name in result}
        except Exception as error:  # whatever somebody else's function raises is reported with its name
            raise ConfigurationError(f"{self.source} fails: {type(error).__name__}: {error}.") from error


def look_up(source: str) -> Callable[..., Any]:
    """Import ``module:name``; modules of the current folder come first.

    Raises
    ------
    ConfigurationError
        There is no such module, or no such function in it.
    """
    module, _, name = source.partition(":")
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        function = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ConfigurationError(
            f"--simulation {source}: {error}; it should be 'module:function', importable from here."
        ) from error
    if not callable(function):
        raise ConfigurationError(f"--simulation {source}: {name} is no function.")
    found: Callable[..., Any] = function
    return found


def free_of(source: str) -> tuple[Free, ...]:
    """Arguments of the function that may be recalibrated: those with a number as default."""
    parameters = list(inspect.signature(look_up(source)).parameters.values())
    return tuple(
        Free(parameter.name, float(parameter.default))
        for parameter in parameters[1:]
        if isinstance(parameter.default, int | float) and not isinstance(parameter.default, bool)
    )
