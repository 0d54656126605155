"""Orders of the nominal series of a gearbox, from its tooth numbers.

The paper selects twenty orders of one gearbox and names the part behind each (Bauer et al., ICIT 2025). As
multiples of the parts' first orders they are those of any gearbox of its make.
"""

from __future__ import annotations

from bench.simulation.model import Gearbox

OUTPUT_SHAFT = (1, 3, 6, 9, 13, 14, 18, 19, 27)
PLANETARY = (1, 3)
CYCLOID_STAGE = (1, 2, 3, 4, 6)
INPUT_GEAR = (1,)
CYCLOID_DISC = (2, 3, 4)
"""multiples the paper selected, of 1, u₁ = z₂/z₁, u₂ = z₄, z₁ and z₃"""
APART = 0.25
"""of an order: nearer ones are not told apart in one revolution, whose noise they more than double"""


def nominal_orders(gearbox: Gearbox) -> tuple[float, ...]:
    """Orders of the nominal series, ascending: those of the output shaft, and of each part whose teeth are known.

    A gearbox that tells no tooth numbers and has the nominal one's ratio counts as that.
    """
    teeth = (gearbox.z1, gearbox.z2, gearbox.z3, gearbox.z4)
    if not any(teeth) and not Gearbox().unlike(gearbox.ratio):
        gearbox = Gearbox()
    orders = {float(i) for i in OUTPUT_SHAFT}
    if gearbox.z1:
        orders |= {float(i * gearbox.z1) for i in INPUT_GEAR}
    if gearbox.z3:
        orders |= {float(i * gearbox.z3) for i in CYCLOID_DISC}
    if gearbox.z4:
        orders |= {float(i * gearbox.z4) for i in CYCLOID_STAGE}
    if gearbox.z1 and gearbox.z2:
        planetary = [i * gearbox.z2 / gearbox.z1 for i in PLANETARY]
        orders |= {f for f in planetary if f >= 1.0 and min(abs(f - g) for g in orders) >= APART}
    return tuple(sorted(orders))


def orders_in_doubt(gearbox: Gearbox) -> tuple[float, ...]:
    """Orders that the nominal simulation has by its list of numbers, but not by the gearbox' tooth numbers, ascending.

    The simulation is defined for one gearbox by twenty numbers with a part beside each. Of another gearbox it does not
    say whether the numbers hold or the parts do. What is near an order of a part is that one.
    """
    if gearbox.ratio <= 1.0:  # no gearbox: a motor that drives directly, a linear axis
        return ()
    own = nominal_orders(gearbox)
    return tuple(f for f in nominal_orders(Gearbox()) if min(abs(f - g) for g in own) >= APART)
