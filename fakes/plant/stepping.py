"""The compiled cycle of the whole bench: transmission error, friction, drives, mechanics, heat, sensors.

numba's cache of ``step_block`` knows this file only, not the compiled functions it calls from its neighbours: whoever
changes one of those must change a line of this file as well, or clear the cache. Twists last changed: passive ones.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fakes.plant.drag_table import look_up
from fakes.plant.drive import report_torque, run_drive
from fakes.plant.faults import INDEX
from fakes.plant.heat import aim_heat, warm
from fakes.plant.hidden.drag import drag as hidden_drag
from fakes.plant.hidden.shafts import misread, torques
from fakes.plant.hidden.shape import shape
from fakes.plant.hidden.twist import standing, twist
from fakes.plant.hidden.warmth import aim_hidden_heat, sense, warm_more
from fakes.plant.mechanics import move
from fakes.plant.noise import normal
from fakes.plant.records import INPUT, LOAD
from fakes.plant.sensors import INPUT_ENCODER, LOAD_ENCODER, read_encoder, read_temperatures, read_torque
from fakes.plant.transmission import advance, aim, drift, place, rotate, series

_INPUT_OFF = INDEX["input_current_off"]
_LOAD_OFF = INDEX["load_current_off"]
_INPUT_RUNAWAY = INDEX["input_runaway"]
_LOAD_RUNAWAY = INDEX["load_runaway"]
_UNCOUPLED = INDEX["load_uncoupled"]
_OUTPUT_STALLED = INDEX["output_stalled"]
_INPUT_STALLED = INDEX["input_stalled"]
_FRICTION = INDEX["friction_raised"]
_HEATING = INDEX["heating_external"]


@njit(cache=True, error_model="numpy")
def _aim_series(p: Any, s: Any, table: Any, te: Any, sine_cosine: Any) -> None:
    """Evaluate the polynomials and lay the interpolation for the next interval. ``te``: parts, slope, target."""
    orders, amplitude, phase, offset, box = table
    place(sine_cosine, orders, s.motor_angle / p.ratio)
    # element by element: an assignment of whole rows would bring the texts of its errors into what is compiled
    for row in range(2):
        for i in range(te.shape[2]):
            te[0, row, i] = te[2, row, i]
    aim(te[2], amplitude, phase, offset, box, s.te_torque, s.te_velocity, s.temperature, s.te_weight)
    for row in range(2):
        for i in range(te.shape[2]):
            te[1, row, i] = (te[2, row, i] - te[0, row, i]) / p.te_interval


@njit(cache=True, error_model="numpy")
def _hold(p: Any, s: Any, enabled: bool, cycle_time: float) -> float:
    """Return the friction of a motor's brake, N·m; it closes a while after the power went off."""
    s.off_time = 0.0 if enabled else s.off_time + cycle_time
    return float(p.brake_torque) if s.off_time > p.brake_delay else 0.0


@njit(cache=True, error_model="numpy")
def _conditions(p: Any, s: Any, drives: Any, states: Any, c: Any, now: Any, active: Any, faults: Any) -> None:
    """Fill what stays the same within the cycle: friction, spring, ripple."""
    viscous = p.viscous + p.viscous_temperature * (s.temperature - p.reference_temperature)
    raised = faults[_FRICTION].value if active[_FRICTION] else 1.0
    now.viscous = raised * max(viscous, p.minimum_viscous)
    now.coulomb = raised * p.coulomb + _hold(drives[INPUT], states[INPUT], c.input_enable != 0, p.cycle_time)
    now.load_dependent = raised * p.load_dependent
    now.load_friction = p.bearing_friction + _hold(drives[LOAD], states[LOAD], c.load_enable != 0, p.cycle_time)
    if active[_INPUT_STALLED]:
        now.coulomb += faults[_INPUT_STALLED].value
    if active[_OUTPUT_STALLED]:
        now.load_friction += faults[_OUTPUT_STALLED].value
    now.stiffness = 0.0 if active[_UNCOUPLED] else p.stiffness
    now.damping = 0.0 if active[_UNCOUPLED] else p.damping
    now.ripple = 0.0
    middle = s.load_angle + 0.5 * p.cycle_time * s.load_velocity
    for i in range(p.ripples):
        now.ripple += p.ripple_amplitude[i] * math.sin(p.ripple_order[i] * middle + p.ripple_phase[i])


@njit(cache=True, error_model="numpy")
def _run_drives(
    s: Any, drives: Any, states: Any, c: Any, now: Any, noise: Any, active: Any, faults: Any, tick: float, off: float
) -> None:
    """Sample both drives once and put their shafts' torques, in the bench's frame, into ``now``.

    ``off`` is what the motor encoder reads beyond its shaft's angle, rad.
    """
    p, d = drives[INPUT], states[INPUT]
    counts = read_encoder(p, d, p.polarity * (s.motor_angle + off), noise[INPUT], active, faults, INPUT_ENCODER)
    stop = c.input_quick_stop != 0
    run_drive(p, d, counts, c.input_enable != 0, c.input_mode, stop, c.input_velocity, c.input_torque, tick)
    if active[_INPUT_OFF]:
        d.torque = 0.0
    if active[_INPUT_RUNAWAY] and c.input_enable != 0:
        d.torque = faults[_INPUT_RUNAWAY].value
    now.motor_torque = p.polarity * p.torque_gain * d.torque - p.torque_offset

    p, d = drives[LOAD], states[LOAD]
    counts = read_encoder(p, d, p.polarity * s.load_angle, noise[LOAD], active, faults, LOAD_ENCODER)
    stop = c.load_quick_stop != 0
    run_drive(p, d, counts, c.load_enable != 0, c.load_mode, stop, c.load_velocity, c.load_torque, tick)
    if active[_LOAD_OFF]:
        d.torque = 0.0
    if active[_LOAD_RUNAWAY] and c.load_enable != 0:
        d.torque = faults[_LOAD_RUNAWAY].value
    now.load_torque = p.polarity * p.torque_gain * d.torque - p.torque_offset - now.ripple


@njit(cache=True, error_model="numpy")
def _measure(
    p: Any, s: Any, drives: Any, states: Any, m: Any, noise: Any, words: Any, active: Any, faults: Any, off: float
) -> None:
    """Fill the cycle's measurement; ``off`` is what the motor encoder reads beyond its shaft's angle, rad."""
    read_torque(p, s, words, active, faults)
    d = drives[INPUT]
    angle = d.polarity * (s.motor_angle + off)
    m.input_position = read_encoder(d, states[INPUT], angle, noise[INPUT], active, faults, INPUT_ENCODER)
    m.input_velocity = states[INPUT].velocity
    m.input_torque = report_torque(d, states[INPUT], normal(words))
    d = drives[LOAD]
    angle = d.polarity * s.load_angle
    m.load_position = read_encoder(d, states[LOAD], angle, noise[LOAD], active, faults, LOAD_ENCODER)
    m.load_velocity = states[LOAD].velocity
    m.load_torque = report_torque(d, states[LOAD], normal(words))
    m.torque_adc = s.torque_adc
    m.lubricant_temperature = s.lubricant_reading
    m.ambient_temperature = s.ambient_reading


class Parts(NamedTuple):
    """All that a plant is made of, as the compiled cycle takes it."""

    plant: NDArray[Any]
    """(1,) parameters of the bench"""
    drives: NDArray[Any]
    """(2,) parameters of the drives"""
    state: NDArray[Any]
    """(1,) of the bench"""
    states: NDArray[Any]
    """(2,) of the drives"""
    conditions: NDArray[Any]
    """(1,) room to work in"""
    words: NDArray[np.uint64]
    """(4,) of the noise"""
    series: tuple[NDArray[np.float64], ...]
    """of the transmission error: orders, amplitude, phase, offset, box"""
    te: NDArray[np.float64]
    """(3, 2, K + 1) the series' parts, slope, target"""
    sine_cosine: NDArray[np.float64]
    """(2, K) sines and cosines of the orders"""
    faults: NDArray[Any]
    """(F,) when each begins and ends"""
    active: NDArray[np.bool_]
    """(F,) room to work in"""
    drag: NDArray[np.float64]
    """(W, C) further friction over speed and temperature, empty without"""
    hidden: tuple[NDArray[Any], ...]
    """the plant's physics of its own (:mod:`fakes.plant.hidden`)"""


@njit(cache=True, error_model="numpy")
def step_block(
    parts: Any, commands: NDArray[Any], measurements: NDArray[Any], trace: NDArray[Any], shown: NDArray[np.float32]
) -> None:
    """Step the plant made of ``parts`` one cycle for each row of ``commands`` (n,) and fill ``measurements`` (n,).

    ``trace`` (n,) takes the true state after each cycle, ``shown`` (n, H, 4) what of each channel is each hidden
    physics'; both are empty where nobody asks.
    """
    p, s, now = parts.plant[0], parts.state[0], parts.conditions[0]
    drives, states, words, table, te = parts.drives, parts.states, parts.words, parts.series, parts.te
    sine_cosine, faults, active, drag, hidden = parts.sine_cosine, parts.faults, parts.active, parts.drag, parts.hidden
    tick = p.cycle_time / p.drive_ticks
    step = tick / p.substeps
    motor_inertia, load_inertia = drives[INPUT].inertia, drives[LOAD].inertia
    noise = np.zeros(2)
    hides = hidden[0].shape[0] > 0
    off = 0.0
    active[:] = False
    first_fault = faults[0].start
    for i in range(faults.shape[0]):
        first_fault = min(first_fault, faults[i].start)
    for n in range(commands.shape[0]):
        c = commands[n]
        if s.cycle >= first_fault:
            for i in range(faults.shape[0]):
                active[i] = faults[i].start <= s.cycle < faults[i].stop
        slow = s.cycle % p.te_interval == 0
        if slow:
            _aim_series(p, s, table, te, sine_cosine)
            aim_heat(p, s)
            if hides:
                aim_hidden_heat(hidden, p, s)
        now.start_theta = s.motor_angle / p.ratio
        now.te_value, now.te_first, now.te_second = series(sine_cosine, te[0], table[0])
        now.te_drift = drift(sine_cosine, te[1]) / p.cycle_time
        _conditions(p, s, drives, states, c, now, active, faults)
        if drag.shape[0] > 0:
            now.coulomb = max(now.coulomb + look_up(drag, abs(s.motor_velocity), s.temperature), 0.0)
        if hides:
            shape(hidden, p, s, now, te[0, 0, -1])
            standing(hidden, now)
            hidden_drag(hidden, p, s, now)
        for side in range(2):
            noise[side] = drives[side].encoder_noise * normal(words) if drives[side].encoder_noise > 0.0 else 0.0

        heat = -s.loss_gearbox
        for _ in range(p.drive_ticks):
            if hides:
                off = misread(hidden, p, s)
            _run_drives(s, drives, states, c, now, noise, active, faults, tick, off)
            if hides:
                torques(hidden, p, s, now, tick)
                twist(hidden, s, now, tick)
            move(p, s, now, motor_inertia, load_inertia, step, p.substeps)
        heat += s.loss_gearbox

        turned = s.motor_angle / p.ratio - now.start_theta
        rotate(sine_cosine, table[0], turned)
        advance(te[0], te[1])
        s.te = now.te_value + turned * (now.te_first + 0.5 * now.te_second * turned)
        s.ripple = now.ripple
        if active[_UNCOUPLED]:
            # joined again, the coupling grips where it then stands
            s.slip = s.motor_angle / p.ratio + s.te - s.load_angle
        s.te_torque += p.te_share * (s.torque - s.te_torque)
        s.te_velocity += p.te_share * (s.motor_velocity / p.ratio - s.te_velocity)
        s.te_weight = min(max(s.te_weight + 2.0 * turned / p.te_reversal_travel, -1.0), 1.0)

        if active[_HEATING]:
            heat += faults[_HEATING].value * p.cycle_time
        before = s.temperature
        warm(p, s, heat)
        s.sensed_torque = s.torque
        if hides:
            warm_more(hidden, p, s, now, s.temperature - before)
            s.sensed_torque = sense(hidden, s, s.torque - now.before_sensor)
            off = misread(hidden, p, s)
        s.travel += abs(turned)
        if slow:
            read_temperatures(p, s, words, active, faults)
        _measure(p, s, drives, states, measurements[n], noise, words, active, faults, off)
        if n < trace.shape[0]:
            t = trace[n]
            t.motor_angle, t.motor_velocity, t.te_velocity = s.motor_angle, s.motor_velocity, s.te_velocity
            t.load_angle, t.torque, t.temperature = s.load_angle, s.torque, s.temperature
            t.weight, t.travel, t.load_velocity = s.te_weight, s.travel, s.load_velocity
        if n < shown.shape[0]:
            for i in range(shown.shape[1]):
                for channel in range(shown.shape[2]):
                    shown[n, i, channel] = hidden[3][i, channel]
        s.cycle += 1
