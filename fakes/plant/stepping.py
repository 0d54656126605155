"""The compiled step of the whole bench: drives, mechanics, heat, transmission error, sensors; one call a block of cycles.

Mechanics: two inertias, input shaft and load motor, joined by gearbox and coupling in series; the flange between them
has no mass of its own, so that the torque in the spring is the torque at the sensor:

    τ = K (θ + TE_kin(θ) − q) + D (θ̇ (1 + TE_kin') − q̇),     θ = motor_angle / u
    J ω̇ = τ_m − τ_0 − (1 + TE_kin') τ/u − friction(ω, τ, T)
    J_L q̈ = τ − load_motor_torque − ripple(q) − d f_b

TE_kin is the series without the elastic part of a_0: at rest q = θ + TE_kin − τ/K, so that the compliance is in a_0 once.
(1 + TE_kin') in the reaction on the input shaft is the virtual work of the kinematic error: no energy is made or lost.

Integration: drift–kick–drift (Strang splitting, second order in the conservative part) with steps of cycle / (drive_ticks ·
substeps), 125 µs for the bench: ωh = 0.13 at the 163 Hz resonance. Friction is taken implicitly on the velocity level: a
shaft that friction can stop within a step is at rest exactly (stiction without creep), one that moves feels exactly F.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fakes.plant.drive import estimate_velocity, read_encoder, report_torque, rest_loops, run_loops
from fakes.plant.faults import INDEX
from fakes.plant.noise import normal
from fakes.plant.records import INPUT, LOAD
from fakes.plant.transmission import advance, aim, place, rotate, series

_ABSURD = 10000.0
"""reading of an open PT100 in °C, outside of any range; negative for a short one"""

_INPUT_FROZEN = INDEX["input_encoder_frozen"]
_INPUT_JUMP = INDEX["input_encoder_jump"]
_INPUT_WRAP = INDEX["input_encoder_wrap"]
_LOAD_FROZEN = INDEX["load_encoder_frozen"]
_LOAD_JUMP = INDEX["load_encoder_jump"]
_LOAD_WRAP = INDEX["load_encoder_wrap"]
_SATURATED = INDEX["torque_sensor_saturated"]
_SENSOR_OPEN = INDEX["torque_sensor_open"]
_SENSOR_FROZEN = INDEX["torque_sensor_frozen"]
_SENSOR_DRIFT = INDEX["torque_sensor_drift"]
_SENSOR_GAIN = INDEX["torque_sensor_gain"]
_PT_OPEN = INDEX["pt100_open"]
_PT_SHORT = INDEX["pt100_short"]
_PT_FROZEN = INDEX["pt100_frozen"]
_PT_OFFSET = INDEX["pt100_offset"]
_AMBIENT_OPEN = INDEX["ambient_pt100_open"]
_AMBIENT_SHORT = INDEX["ambient_pt100_short"]
_INPUT_OFF = INDEX["input_current_off"]
_LOAD_OFF = INDEX["load_current_off"]
_INPUT_RUNAWAY = INDEX["input_runaway"]
_LOAD_RUNAWAY = INDEX["load_runaway"]
_UNCOUPLED = INDEX["load_uncoupled"]
_OUTPUT_STALLED = INDEX["output_stalled"]
_INPUT_STALLED = INDEX["input_stalled"]
_FRICTION = INDEX["friction_raised"]
_HEATING = INDEX["heating_external"]


@njit(cache=True)
def _encoder(p: Any, s: Any, angle: float, noise: float, active: Any, faults: Any, first: int) -> int:
    """Return the counts of an encoder with its faults; ``first`` is the row of its frozen fault, jump and wrap follow."""
    if active[first]:
        return int(s.counts)
    counts = read_encoder(p, angle, noise)
    if active[first + 1]:
        counts += int(faults[first + 1].value)
    if active[first + 2]:
        span = 1 << int(faults[first + 2].value)
        counts = counts % span
    return counts


@njit(cache=True)
def _step_drive(
    p: Any, s: Any, counts: int, enabled: bool, mode: int, quick: bool, velocity: float, torque: float, tick: float
) -> None:
    """Sample one drive: velocity estimate always, loops with power on only."""
    estimate_velocity(p, s, counts, tick)
    if enabled:
        run_loops(p, s, mode, quick, velocity, torque, tick)
    else:
        rest_loops(s)


@njit(cache=True)
def _kick(velocity: float, force: float, friction: float, viscous: float, inertia: float, step: float) -> float:
    """Return the velocity after a step under ``force``, Coulomb ``friction`` and ``viscous`` drag, both implicit."""
    free = velocity + step * force / inertia
    grip = step * friction / inertia
    if free > grip:
        return (free - grip) / (1.0 + step * viscous / inertia)
    if free < -grip:
        return (free + grip) / (1.0 + step * viscous / inertia)
    return 0.0


@njit(cache=True)
def _slow(p: Any, s: Any, orders: Any, amplitude: Any, phase: Any, offset: Any, box: Any, te: Any, turn: Any) -> None:
    """Evaluate the polynomials and lay the interpolation for the next interval. ``te`` (3, 2, K + 1): parts, slope, target."""
    place(turn, orders, s.motor_angle / p.ratio)
    te[0] = te[2]
    aim(te[2], amplitude, phase, offset, box, s.te_torque, s.te_velocity, s.temperature, s.te_weight)
    te[1] = (te[2] - te[0]) / p.te_interval


@njit(cache=True)
def _read_sensors(p: Any, s: Any, words: Any, active: Any, faults: Any, slow: bool) -> None:
    """Take the readings of torque sensor (each cycle) and thermometers (each slow interval)."""
    noise = normal(words)
    torque = s.torque * p.sensor_gain
    if active[_SENSOR_GAIN]:
        torque *= faults[_SENSOR_GAIN].value
    torque += p.sensor_zero + p.sensor_noise * noise
    if active[_SENSOR_DRIFT]:
        torque += faults[_SENSOR_DRIFT].value * (s.cycle - faults[_SENSOR_DRIFT].start) * p.cycle_time
    if active[_SENSOR_OPEN]:
        torque = faults[_SENSOR_OPEN].value + p.sensor_noise * noise
    counts = math.floor(torque * p.sensor_counts + 0.5)
    if active[_SATURATED]:
        counts = p.sensor_limit + 1.0 if faults[_SATURATED].value > 0 else -p.sensor_limit - 1.0
    if not active[_SENSOR_FROZEN]:
        s.torque_adc = int(min(max(counts, -p.sensor_limit - 1.0), p.sensor_limit))
    if slow:
        lubricant = s.temperature + p.lubricant_offset + p.lubricant_noise * normal(words)
        surroundings = p.ambient + p.ambient_rate * s.cycle * p.cycle_time
        surroundings += p.ambient_offset + p.ambient_noise * normal(words)
        if active[_PT_OFFSET]:
            lubricant += faults[_PT_OFFSET].value
        if active[_PT_OPEN]:
            lubricant = _ABSURD
        if active[_PT_SHORT]:
            lubricant = -_ABSURD
        if active[_AMBIENT_OPEN]:
            surroundings = _ABSURD
        if active[_AMBIENT_SHORT]:
            surroundings = -_ABSURD
        if not active[_PT_FROZEN]:
            s.lubricant_reading = lubricant
        s.ambient_reading = surroundings


@njit(cache=True)
def step_block(
    plant: NDArray[Any],
    drives: NDArray[Any],
    state: NDArray[Any],
    drive_states: NDArray[Any],
    words: NDArray[np.uint64],
    orders: NDArray[np.float64],
    amplitude: NDArray[np.float64],
    phase: NDArray[np.float64],
    offset: NDArray[np.float64],
    box: NDArray[np.float64],
    te: NDArray[np.float64],
    turn: NDArray[np.float64],
    faults: NDArray[Any],
    active: NDArray[np.bool_],
    commands: NDArray[Any],
    measurements: NDArray[Any],
) -> None:
    """Step the plant one cycle for each row of ``commands`` (n,) and fill ``measurements`` (n,)."""
    p, s = plant[0], state[0]
    pm, pl = drives[INPUT], drives[LOAD]
    sm, sl = drive_states[INPUT], drive_states[LOAD]
    ticks, substeps = p.drive_ticks, p.substeps
    tick = p.cycle_time / ticks
    step = tick / substeps
    half = 0.5 * step
    ratio = p.ratio
    per_ratio = 1.0 / ratio
    motor_inertia, load_inertia = pm.inertia, pl.inertia
    coulomb, load_dependent = p.coulomb, p.load_dependent
    for n in range(commands.shape[0]):
        c = commands[n]
        cycle = s.cycle
        for i in range(faults.shape[0]):
            active[i] = faults[i].start <= cycle < faults[i].stop
        slow = cycle % p.te_interval == 0
        if slow:
            _slow(p, s, orders, amplitude, phase, offset, box, te, turn)
        start_theta = s.motor_angle * per_ratio
        te_value, te_first, te_second = series(turn, te[0], orders)

        viscous = p.viscous + p.viscous_temperature * (s.temperature - p.reference_temperature)
        viscous = max(viscous, p.minimum_viscous)
        coulomb = p.coulomb
        load_dependent = p.load_dependent
        if active[_FRICTION]:
            viscous *= faults[_FRICTION].value
            coulomb *= faults[_FRICTION].value
            load_dependent *= faults[_FRICTION].value
        motor_hold = faults[_INPUT_STALLED].value if active[_INPUT_STALLED] else 0.0
        load_hold = faults[_OUTPUT_STALLED].value if active[_OUTPUT_STALLED] else 0.0
        input_on, load_on = c.input_enable != 0, c.load_enable != 0
        sm.off_time = 0.0 if input_on else sm.off_time + p.cycle_time
        sl.off_time = 0.0 if load_on else sl.off_time + p.cycle_time
        if sm.off_time > pm.brake_delay:
            motor_hold += pm.brake_torque
        if sl.off_time > pl.brake_delay:
            load_hold += pl.brake_torque
        load_friction = p.bearing_friction + load_hold
        stiffness = 0.0 if active[_UNCOUPLED] else p.stiffness
        damping = 0.0 if active[_UNCOUPLED] else p.damping
        ripple = 0.0
        middle = s.load_angle + 0.5 * p.cycle_time * s.load_velocity
        for i in range(p.ripples):
            ripple += p.ripple_amplitude[i] * math.sin(p.ripple_order[i] * middle + p.ripple_phase[i])

        angle, velocity = s.motor_angle, s.motor_velocity
        load_angle, load_velocity = s.load_angle, s.load_velocity
        torque = s.torque
        slip = s.slip
        work_motor = work_load = loss_gearbox = loss_bearing = 0.0
        load_noise = pl.encoder_noise * normal(words)
        motor_noise = pm.encoder_noise * normal(words) if pm.encoder_noise > 0.0 else 0.0
        for _ in range(ticks):
            counts = _encoder(pm, sm, pm.polarity * angle, motor_noise, active, faults, _INPUT_FROZEN)
            _step_drive(
                pm, sm, counts, input_on, c.input_mode, c.input_quick_stop != 0, c.input_velocity, c.input_torque, tick
            )
            counts = _encoder(pl, sl, pl.polarity * load_angle, load_noise, active, faults, _LOAD_FROZEN)
            _step_drive(
                pl, sl, counts, load_on, c.load_mode, c.load_quick_stop != 0, c.load_velocity, c.load_torque, tick
            )
            if active[_INPUT_OFF]:
                sm.torque = 0.0
            if active[_LOAD_OFF]:
                sl.torque = 0.0
            if active[_INPUT_RUNAWAY]:
                sm.torque = faults[_INPUT_RUNAWAY].value
            if active[_LOAD_RUNAWAY]:
                sl.torque = faults[_LOAD_RUNAWAY].value
            drive_torque = pm.polarity * (pm.torque_gain * sm.torque - pm.torque_offset)
            load_torque = pl.polarity * (pl.torque_gain * sl.torque - pl.torque_offset) - ripple
            for _ in range(substeps):
                angle += half * velocity
                load_angle += half * load_velocity
                turned = angle * per_ratio - start_theta
                gain = 1.0 + te_first + te_second * turned
                twist = angle * per_ratio + te_value + turned * (te_first + 0.5 * te_second * turned)
                twist -= load_angle + slip
                rate = velocity * per_ratio * gain - load_velocity
                torque = stiffness * twist + damping * rate
                force = drive_torque - torque * gain * per_ratio
                friction = coulomb + load_dependent * abs(torque) * per_ratio + motor_hold
                after = _kick(velocity, force, friction, viscous, motor_inertia, step)
                path = half * (velocity + after)
                work_motor += drive_torque * path
                loss_gearbox += (
                    force - motor_inertia * (after - velocity) / step
                ) * path + damping * rate * rate * step
                velocity = after
                force = torque + load_torque
                after = _kick(load_velocity, force, load_friction, 0.0, load_inertia, step)
                path = half * (load_velocity + after)
                work_load += load_torque * path
                loss_bearing += (force - load_inertia * (after - load_velocity) / step) * path
                load_velocity = after
                angle += half * velocity
                load_angle += half * load_velocity
        turned = angle * per_ratio - start_theta
        rotate(turn, orders, turned)
        advance(te[0], te[1])
        if active[_UNCOUPLED]:
            # joined again, the coupling grips where it then stands
            slip = angle * per_ratio + te_value - load_angle
        s.motor_angle, s.motor_velocity = angle, velocity
        s.load_angle, s.load_velocity = load_angle, load_velocity
        s.torque, s.slip, s.te, s.ripple = torque, slip, te_value, ripple
        s.te_torque += p.te_share * (torque - s.te_torque)
        s.te_velocity += p.te_share * (velocity * per_ratio - s.te_velocity)
        s.te_weight = min(max(s.te_weight + 2.0 * turned / p.te_reversal_travel, -1.0), 1.0)
        s.work_motor += work_motor
        s.work_load += work_load
        s.loss_gearbox += loss_gearbox
        s.loss_bearing += loss_bearing
        surroundings = p.ambient + p.ambient_rate * cycle * p.cycle_time
        heat = loss_gearbox - (s.temperature - surroundings) / p.heat_resistance * p.cycle_time
        if active[_HEATING]:
            heat += faults[_HEATING].value * p.cycle_time
        s.temperature += heat / p.heat_capacity

        _read_sensors(p, s, words, active, faults, slow)
        m = measurements[n]
        m.input_position = _encoder(pm, sm, pm.polarity * angle, motor_noise, active, faults, _INPUT_FROZEN)
        m.input_velocity = sm.velocity
        m.input_torque = report_torque(pm, sm, normal(words))
        m.load_position = _encoder(pl, sl, pl.polarity * load_angle, load_noise, active, faults, _LOAD_FROZEN)
        m.load_velocity = sl.velocity
        m.load_torque = report_torque(pl, sl, normal(words))
        m.torque_adc = s.torque_adc
        m.lubricant_temperature = s.lubricant_reading
        m.ambient_temperature = s.ambient_reading
        s.cycle = cycle + 1
