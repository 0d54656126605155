"""A plant named with what is concealed in it: ``rh380n?conceal=77``.

The part behind the question mark holds ``conceal`` (the seed), and may hold ``kinds`` (their names, comma-separated, in
place of drawn ones; empty for none), ``weak`` (0: without weak orders) and ``ledger`` (a file for the examiner).
"""

from __future__ import annotations

from dataclasses import replace
from urllib.parse import parse_qsl

import numpy as np

from fakes.plant.draw import draw, draw_plant
from fakes.plant.errors import PlantError
from fakes.plant.plant_file import read_plant
from fakes.plant.truth import PlantTruth

_KNOWN = ("conceal", "kinds", "weak", "ledger")


def plant_of(name: str) -> PlantTruth:
    """Return the truth of a plant file's name, with what is concealed in it where the name says so.

    Raises:
        PlantError: the plant file is missing or wrong, or what stands behind the question mark is.
    """
    base, mark, behind = name.partition("?")
    truth = read_plant(base)
    if not mark:
        return truth
    asked = dict(parse_qsl(behind, keep_blank_values=True))
    if not asked.keys() <= set(_KNOWN) or not asked.get("conceal", "").isdecimal():
        raise PlantError(f"plant {name}: behind the question mark stand conceal=SEED and none but {', '.join(_KNOWN)}")
    seed = int(asked["conceal"])
    if "kinds" in asked:
        kinds = [kind for kind in asked["kinds"].split(",") if kind]
        rng = np.random.default_rng([seed, 1516])
        hidden = tuple(draw(kind, rng) for kind in kinds)
        drawn = replace(draw_plant(truth, seed, 0), hidden=hidden)
    else:
        drawn = draw_plant(truth, seed)
    if asked.get("weak") == "0":
        drawn = drawn.without_weak_orders()
    return replace(drawn, ledger=asked.get("ledger", ""))
