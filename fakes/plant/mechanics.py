"""Mechanics of the bench: two inertias, input shaft and load motor, joined by gearbox and coupling in series.

The flange between gearbox and coupling has no mass of its own, so that the torque in the spring is that at the sensor:

    τ = K (θ + TE_kin(θ) − q) + D (θ̇ (1 + TE_kin') − q̇),     θ = motor_angle / u
    J ω̇ = τ_m − τ_0 − (1 + TE_kin') τ/u − friction(ω, τ, T)
    J_L q̈ = τ − load_motor_torque − ripple(q) − d f_b

TE_kin is the series without the elastic part of a_0: at rest q = θ + TE_kin − τ/K, so the compliance is in a_0 once.
(1 + TE_kin') in the reaction on the input shaft is the virtual work of the kinematic error: no energy is made or lost.

Integration: drift–kick–drift (Strang splitting, second order in the conservative part) with steps of
cycle / (drive_ticks · substeps), 125 µs for the bench: ωh = 0.13 at the 163 Hz resonance. Friction is implicit on the
velocity level: a shaft that friction can stop within a step is at rest exactly (stiction without creep), one that moves
feels exactly F.
"""

from __future__ import annotations

from typing import Any

from numba import njit


@njit(cache=True, error_model="numpy")
def _kick(velocity: float, force: float, friction: float, viscous: float, inertia: float, step: float) -> float:
    """Return the velocity after a step under ``force``, Coulomb ``friction`` and ``viscous`` drag, both implicit."""
    free = velocity + step * force / inertia
    grip = step * friction / inertia
    if free > grip:
        return (free - grip) / (1.0 + step * viscous / inertia)
    if free < -grip:
        return (free + grip) / (1.0 + step * viscous / inertia)
    return 0.0


@njit(cache=True, error_model="numpy")
def move(p: Any, s: Any, now: Any, motor_inertia: float, load_inertia: float, step: float, count: int) -> None:
    """Move both shafts by ``count`` steps under the conditions ``now`` (torques in the bench's frame).

    The transmission error's parts move on in between: a step of them once a cycle would be a step of the torque, and
    what is read at the cycle's end would be off from the mean by up to 20 mN·m while the bench accelerates.
    """
    half = 0.5 * step
    per_ratio = 1.0 / p.ratio
    angle, velocity = s.motor_angle, s.motor_velocity
    load_angle, load_velocity = s.load_angle, s.load_velocity
    value = now.te_value
    work_motor = work_load = loss_gearbox = loss_bearing = torque = 0.0
    for _ in range(count):
        angle += half * velocity
        load_angle += half * load_velocity
        turned = angle * per_ratio - now.start_theta
        gain = 1.0 + now.te_first + now.te_second * turned
        value += half * now.te_drift
        twist = angle * per_ratio + value + turned * (now.te_first + 0.5 * now.te_second * turned)
        twist -= load_angle + s.slip
        rate = velocity * per_ratio * gain + now.te_drift - load_velocity
        torque = now.stiffness * twist + now.damping * rate

        force = now.motor_torque - torque * gain * per_ratio
        friction = now.coulomb + now.load_dependent * abs(torque) * per_ratio
        after = _kick(velocity, force, friction, now.viscous, motor_inertia, step)
        path = half * (velocity + after)
        # what springs of asperities hold is given back or turned to heat within a few degrees: it counts as heat
        work_motor += (now.motor_torque + now.spring_torque) * path
        rubbed = force + now.spring_torque - motor_inertia * (after - velocity) / step
        loss_gearbox += rubbed * path + now.damping * rate * rate * step
        velocity = after

        force = torque + now.load_torque
        after = _kick(load_velocity, force, now.load_friction, 0.0, load_inertia, step)
        path = half * (load_velocity + after)
        work_load += now.load_torque * path
        loss_bearing += (force - load_inertia * (after - load_velocity) / step) * path
        load_velocity = after

        angle += half * velocity
        load_angle += half * load_velocity
        value += half * now.te_drift
    now.te_value = value
    s.motor_angle, s.motor_velocity = angle, velocity
    s.load_angle, s.load_velocity = load_angle, load_velocity
    s.torque = torque
    s.work_motor += work_motor
    s.work_load += work_load
    s.loss_gearbox += loss_gearbox
    s.loss_bearing += loss_bearing
