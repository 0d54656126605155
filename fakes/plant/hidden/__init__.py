"""Physics of its own that a plant may have: switched on in its file or drawn from a seed, integrated with the dynamics.

:mod:`kinds` is the table of what there is, :mod:`fakes.plant.draw` draws a plant from a seed; the other modules are the
equations, compiled, one a part of the bench.
"""

from fakes.plant.hidden.kinds import KINDS, Hidden, Kind

__all__ = ["KINDS", "Hidden", "Kind"]
