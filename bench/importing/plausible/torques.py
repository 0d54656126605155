"""Checks of torques: inertia is positive, friction takes power, and the motor carries the load."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from bench.importing.channel_mapping import PartMapping
from bench.importing.looking.words import SET_VALUE
from bench.importing.motor_angle import INTEGRAL, OF_OUTPUT
from bench.importing.plausible.factors import reason
from bench.importing.plausible.motion import POSITION, SURE, Blocks, Law, blocks, law
from bench.importing.plausible.others import MOTIONS, Beside, law_beside
from bench.importing.table import ChannelTable

FloatArray = NDArray[np.float64]
_EXPLAINED = 0.2
"""Share of the torque's variance from which the law of motion says anything."""
_LEAST_FACTOR, _MOST_FACTOR = 0.4, 2.5
"""Factors of the load torque in the motor's, over the ratio, outside of which a scale is wrong for sure."""
_GAIN = 0.3
"""How far this factor may be from 1 without a note: a plain gearbox loses less than that."""
_LEVEL = 0.1
"""Standard deviation of a load over its size, up to which it is constant."""
_WITH_CARE = 2.0
"""Standard deviations by which the factor has to be farther than that."""


def torques(table: ChannelTable, ratio: float, where: str, wanted: Mapping[str, PartMapping]) -> list[str]:
    """Say what cannot be of the torques, one sentence each; ``where`` is the mapping file, ``wanted`` its channels."""
    values = {name: channel.si for name, channel in table.channels.items()}
    if "motor_angle" not in values:
        return []
    found: list[str] = []
    if "motor_torque" in values:
        current = "motor_torque" in wanted and wanted["motor_torque"].torque_constant is not None
        found += _motor_side(table, values, ratio, where, current=current)
        if any("channels.load_torque" in sentence for sentence in found):
            return found  # the load motor's torque is compared with the load torque, which is wrong itself
    return [*found, *_load_side(values, ratio, where, linear=table.linear)]


def _varies(load: FloatArray) -> bool:
    """Whether a load varies: a constant one is not told from a zero that is off, so nothing tells its factor."""
    finite = load[np.isfinite(load)]
    return bool(finite.size and np.std(finite) > _LEVEL * np.sqrt(np.mean(finite**2)))


def _averaged(values: dict[str, FloatArray], ratio: float, *names: str, positioned: bool = True) -> Blocks | None:
    """Blocks of the motor's motion and of the channels named, with the output's position where that is wanted."""
    wanted = {name: values[name] for name in names}
    if positioned:
        wanted[POSITION] = values["load_angle"] if "load_angle" in values else values["motor_angle"] / ratio
    return blocks(values["time"], values["motor_angle"], wanted)


def _law_of_motor(table: ChannelTable, values: dict[str, FloatArray], ratio: float, load: str | None) -> Beside | None:
    """The motor's law of motion; where no torque sensor holds what acts behind it, beside the axes in ``aux``."""
    if load == "load_torque":
        averaged = _averaged(values, ratio, "motor_torque", load, positioned=False)
        fit = None if averaged is None else law(averaged, "motor_torque", load, linear=table.linear)
        return None if fit is None else Beside(fit)
    units = {name: channel.spec.unit for name, channel in table.channels.items() if name.startswith("aux/")}
    others = {name: unit for name, unit in units.items() if unit in MOTIONS and not SET_VALUE.search(name.lower())}
    loads = [load] if load is not None else []
    averaged = _averaged(values, ratio, "motor_torque", *loads, *others)
    return None if averaged is None else law_beside(averaged, "motor_torque", load, others, linear=table.linear)


def _motor_side(
    table: ChannelTable, values: dict[str, FloatArray], ratio: float, where: str, *, current: bool
) -> Iterator[str]:
    """The motor's torque accelerates it, turns it against friction, and carries the load."""
    recorded = next((name for name in ("load_torque", "load_motor_torque") if name in values), None)
    load = recorded if recorded is not None and _varies(values[recorded]) else None
    found = _law_of_motor(table, values, ratio, load)
    if found is None or found.law.share < _EXPLAINED:
        return
    fit = found.law
    unit = "kg" if table.linear else "kg·m²"
    driven = _unless(found, recorded)
    beside = f" beside what {_listed(found.taken)} do{'es' if len(found.taken) == 1 else ''}" if found.taken else ""
    if load == "load_torque" and fit.load is not None and abs(fit.load_t) > SURE:
        yield from _load(fit.load * ratio, ratio, where, current=current)
        if fit.load * ratio < 0:
            return
    negative_inertia, negative_loss = fit.inertia_t < -SURE, fit.loss_t < -SURE
    # a load that is found with its sign and size says that both torques have one sign
    carries = load is not None and fit.load_t > SURE
    moves = _origin_of_motion(table)
    if negative_inertia and fit.loss < 0.0:
        likely = f"{moves} (or of motor_torque and {load} both)" if carries else f"motor_torque (or of {moves})"
        yield (
            f"{where}: channels.motor_torque gives a negative inertia ({fit.inertia:.4g} {unit}) and "
            f"friction that takes {fit.loss:.4g} W{beside}, both should be positive{driven}: likely a wrong sign; "
            f"scale times -1 of {likely} would be right."
        )
    elif negative_inertia:
        over = (
            "" if load == "load_torque" else "a force over the position that is no sine of it (a spring, a balancer), "
        )
        yield (
            f"{where}: channels.motor_torque gives a negative inertia ({fit.inertia:.4g} {unit}) though "
            f"friction takes power: likely {over}friction that yields before it slides, or a torque that lags behind "
            "motor_angle; of these only the last is a fault of the data, the same filter and clock for both would be "
            "right."
        )
    elif negative_loss and carries:
        yield _less_than_carried(fit, f"{load}", moves, where, beside)
    elif negative_loss:
        likely = "motor_torque" if load is None else f"motor_torque or of {load}"
        yield (
            f"{where}: channels.motor_torque gives friction that takes {fit.loss:.4g} W{beside}, which should be "
            f"positive{driven}: likely a wrong sign; scale times -1 of {likely} would be right."
        )


def _less_than_carried(fit: Law, load: str, moves: str, where: str, beside: str) -> str:
    """The motor gives less power than the load takes, though both torques have one sign."""
    found = (
        f"{where}: channels.motor_torque gives friction that takes {fit.loss:.4g} W{beside}, which should be positive "
        f"(it is {-100.0 * fit.loss / fit.carried:.2g} % of the power that {load} carries): "
    )
    small = (
        f"motor_torque is reported too small against {load} (a gain that is off or falls with the load, or a zero that "
        "is off where the motor turns one way; a calibration of both would tell)"
    )
    if fit.inertia_t > SURE:
        return f"{found}the inertia is positive, so the signs are right and {small}."
    return (
        f"{found}either {small}, or both torques have the wrong sign (scale times -1 of {moves}, or of motor_torque "
        f"and {load} both, would be right); the data do not tell which."
    )


def _origin_of_motion(table: ChannelTable) -> str:
    """The channel that the motor's angle was made of, as a mapping names it."""
    origin = table.channels["motor_angle"].spec.origin
    side = "load" if OF_OUTPUT in origin else "motor"
    return f"{side}_velocity" if origin.startswith(INTEGRAL) else f"{side}_angle"


def _unless(found: Beside, load: str | None) -> str:
    """What else may drive the motor, as half a sentence: a load that no channel holds, or an axis along with it."""
    causes = ["a load that no channel holds drives the motor"] if load is None else []
    if found.taken:
        causes.append(f"{_listed(found.taken)} {'is a set value' if len(found.taken) == 1 else 'are set values'} of it")
    if found.along:
        verb = "does, which moves" if len(found.along) == 1 else "do, which move"
        causes.append(f"{_listed(found.along)} {verb} along with it and cannot be told from it")
    return f", unless {' or '.join(causes)}" if causes else ""


def _listed(names: tuple[str, ...]) -> str:
    """Auxiliary channels as a mapping names them."""
    *most, last = (name.replace("/", ".", 1) for name in names)
    return f"{', '.join(most)} and {last}" if most else last


def _load_side(values: dict[str, FloatArray], ratio: float, where: str, *, linear: bool) -> Iterator[str]:
    """What the load torque has beside the load motor's accelerates the load: both have the same sign."""
    if not {"load_torque", "load_motor_torque"} <= values.keys():
        return
    averaged = _averaged(values, ratio, "load_torque", "load_motor_torque")
    fit: Law | None = None if averaged is None else law(averaged, "load_torque", "load_motor_torque", linear=linear)
    if fit is None or fit.share < _EXPLAINED or fit.load is None:
        return
    if fit.load_t < -SURE:
        yield (
            f"{where}: channels.load_motor_torque is found {fit.load:.4g} times in load_torque beside what accelerates "
            "the load, it should be 1: likely a wrong sign; scale times -1 of load_motor_torque would be right (it is "
            "positive where it opposes motion towards positive angles)."
        )


def _load(factor: float, ratio: float, where: str, *, current: bool) -> Iterator[str]:
    """The motor carries the load: over the ratio, and with the same sign."""
    if _LEAST_FACTOR < factor < _MOST_FACTOR:
        return  # efficiency, and a load that comes with the speed; a gain that is off is noted
    constant = f", or torque_constant times {1.0 / factor:.4g} of motor_torque" if current else ""
    yield (
        f"{where}: channels.load_torque over gearbox.ratio is found {factor:.4g} times in motor_torque, "
        f"it should be 1: {reason(1.0 / factor, ratio)} of load_torque{constant}."
    )


def gain_note(table: ChannelTable, ratio: float, wanted: Mapping[str, PartMapping]) -> str | None:
    """Say that the load torque is found in the motor's with a factor that is off by more than a gearbox loses, but not
    by so much that it cannot be; None where it is not, or is not known well.
    """
    values = {name: channel.si for name, channel in table.channels.items()}
    if not {"motor_angle", "motor_torque", "load_torque"} <= values.keys() or not _varies(values["load_torque"]):
        return None
    found = _law_of_motor(table, values, ratio, "load_torque")
    if found is None or found.law.share < _EXPLAINED or found.law.load is None or abs(found.law.load_t) < SURE:
        return None
    factor, spread = found.law.load * ratio, found.law.load_spread * abs(ratio)
    beyond = abs(factor - 1.0) - _WITH_CARE * spread > _GAIN
    if not (beyond and _LEAST_FACTOR < factor < _MOST_FACTOR):
        return None
    constant = "torque_constant" if wanted["motor_torque"].torque_constant is not None else "scale"
    lossy = f", or a gearbox that passes on {100.0 / factor:.0f} % of its power" if factor > 1.0 else ""
    return (
        f"load_torque over gearbox.ratio is found {factor:.3g} ± {spread:.1g} times in motor_torque, it should be 1: "
        f"a gain may be off ({constant} times {1.0 / factor:.3g} of motor_torque, or scale times {factor:.3g} "
        f"of load_torque, makes them agree){lossy}"
    )
