// The view "Now": state, values one reads from two metres, live plots, the order spectrum of the current revolution.

import { get } from "./api.js";
import { buttons } from "./acts.js";
import { Buffers } from "./buffers.js";
import { bandPlot, curvePlot, modelText, showSpectrum, spectrumPlot } from "./charts.js";
import { savePicture, saveValues } from "./marks.js";
import { running, state } from "./state.js";
import { $, choice, clock, DEGREES, duration, make, number } from "./text.js";

export const buffers = new Buffers();
const NAMES = ["motor_velocity_setpoint", "motor_velocity", "load_motor_torque_setpoint", "load_torque", "temperature"];
const WINDOWS = [[60, "1 min"], [600, "10 min"], [3600, "1 h"], [36000, "10 h"]];
const plots = {};
const STALE_MS = 3000;
let seconds = 600, dirty = true, lastAct = "", heard = 0, moving = 0;

export function open() {
  plots.speed = bandPlot($("plot-speed"), { title: "Speed, load side, °/s", least: 0.5 });
  plots.torque = bandPlot($("plot-torque"), { title: "Load torque, N·m", least: 5 });
  plots.temperature = bandPlot($("plot-temperature"), { title: "Lubricant, °C", set: "expected", least: 0.3 });
  plots.spectrum = spectrumPlot($("plot-spectrum"));
  plots.curve = curvePlot($("plot-curve"), 210, "model", true);
  choice($("windows"), WINDOWS, seconds, value => { seconds = Number(value); dirty = true; });
  choice($("orders"), [[320, "all"], [160, "to 160"], [50, "to 50"]], 320, value => { plots.spectrum.range = [0, Number(value)]; spectrum(); });
  $("live-png").addEventListener("click", () => savePicture([plots.speed, plots.torque, plots.temperature], "live"));
  $("live-csv").addEventListener("click", () => saveValues([plots.speed, plots.torque, plots.temperature], "live"));
  $("te-png").addEventListener("click", () => savePicture([plots.spectrum, plots.curve], "transmission-error"));
  $("te-csv").addEventListener("click", () => saveValues([plots.spectrum, plots.curve], "transmission-error"));
  fit();
  window.addEventListener("resize", fit);
  for (const above of ["header", "#tabs", "#condition", "#te-text", "#model-text"]) new ResizeObserver(fit).observe(document.querySelector(above));
  setInterval(draw, 250);
  setInterval(stale, 500);
}

// Of a wide screen the plots take the height that is left beside the values, as long as one can read them then.
const STACKS = [[["speed", 1 / 3, 260], ["torque", 1 / 3, 260], ["temperature", 1 / 3, 260]], [["spectrum", 0.6, 420], ["curve", 0.4, 280]]];
const ELSE = { speed: 170, torque: 170, temperature: 170, spectrum: 330, curve: 210 };
const LEAST = 96, BELOW = 14;
function fit() {
  if ($("now").hidden) return;
  for (const stack of STACKS) {
    const card = plots[stack[0][0]].place.closest(".card");
    // what the card holds beside its plots: titles, texts, buttons, however many lines they take
    const around = card.lastElementChild.getBoundingClientRect().bottom - card.getBoundingClientRect().top - stack.reduce((sum, [name]) => sum + plots[name].place.offsetHeight, 0);
    const left = innerHeight - card.getBoundingClientRect().top - scrollY - around - BELOW;
    for (const [name, share, most] of stack) {
      const height = innerWidth < 1200 ? ELSE[name] : Math.round(Math.min(most, Math.max(LEAST, left * share)));
      plots[name].place.style.height = `${height}px`;
      plots[name].resize(height);
    }
  }
}

export async function load() {
  const [fine, coarse] = await Promise.all([get("history/fine"), get("history/coarse")]);
  buffers.load(fine, coarse);
  dirty = true;
}

export function live(bucket) { buffers.add(bucket); dirty = true; heard = Date.now(); moving = Date.now(); tiles(bucket.values); }
export function clear() { buffers.clear(); dirty = true; }

// How the bench is, with a run or without one; while rows come, those are newer.
export function condition(message) {
  state.condition = message;
  showCondition();
  if (message.type === "unread") return;
  heard = Date.now();
  const values = Object.fromEntries(Object.entries(message.values).map(([name, value]) => [name, [value, value, value, value]]));
  if (Date.now() - moving > 1000) tiles(values);
  if (message.source === "idle") idle(message.at, values);
}

// The plots go on while nothing runs; after a run in fast time, whose clock is ahead, they keep what it measured.
const EVERY_S = 0.25;
function idle(at, values) {
  const last = buffers.last();
  if (last && at < last.end) return;
  buffers.add({ start: last && at - last.end < 3 * EVERY_S ? last.end : at - EVERY_S, end: at, values });
  dirty = true;
}

// An old value in large figures would be taken for the state of the bench: it goes as soon as it is old.
function stale() {
  const old = Date.now() - heard > STALE_MS || state.gone;
  document.querySelector(".tiles").classList.toggle("stale", old);
  if (!old) return;
  for (const id of ["speed", "torque", "temperature", "angle", "motor"]) { $(`v-${id}`).textContent = "–"; $(`s-${id}`).textContent = ""; }
  for (const id of ["speed", "torque", "temperature"]) $(`l-${id}`).replaceChildren();
  $("s-speed").textContent = state.gone ? "not known" : running() ? "no value comes" : "the bench is not read";
  showCondition();
}

function tiles(values) {
  const { ratio, limits } = state.about;
  const set = (id, value, digits, unit) => $(id).replaceChildren(number(value, digits), make("i", {}, unit));
  const mean = name => values[name]?.[2];
  const velocity = mean("motor_velocity");
  set("v-speed", velocity === undefined ? undefined : velocity / ratio * DEGREES, 2, "°/s");
  const wanted = values.motor_velocity_setpoint?.[3];
  $("s-speed").textContent = wanted === undefined ? "" : `set ${number(wanted / ratio * DEGREES, 2)} °/s · motor ${number(velocity * 60 / (2 * Math.PI), 0)} rpm`;
  limit("l-speed", velocity / ratio * DEGREES, limits.motor_speed / ratio * DEGREES, 1, "°/s");
  set("v-torque", mean("load_torque"), 1, "N·m");
  const torque = values.load_motor_torque_setpoint?.[3];
  $("s-torque").textContent = torque === undefined ? "" : `set ${number(torque, 0)} N·m`;
  limit("l-torque", mean("load_torque"), limits.load_torque, 0, "N·m");
  set("v-temperature", mean("temperature"), 1, "°C");
  const target = running() ? state.status.target : null;
  $("s-temperature").textContent = Number.isFinite(target) && target !== null ? `wanted ${number(target, 1)} °C` : values.ambient_temperature ? `room ${number(mean("ambient_temperature"), 1)} °C` : "";
  limit("l-temperature", mean("temperature"), limits.temperature, 0, "°C", true);
  const angle = values.load_angle?.[3];
  // rounded first: 359.97° is 0.0, not 360.0
  set("v-angle", angle === undefined ? undefined : (Math.round(angle * DEGREES * 10) % 3600 + 3600) % 3600 / 10, 1, "°");
  $("s-angle").textContent = values.motor_angle ? `motor ${number(values.motor_angle[3] * DEGREES / 360, 1)} rev` : "";
  set("v-motor", mean("motor_torque"), 2, "N·m");
  const [low, high] = values.motor_torque ?? [];
  $("s-motor").textContent = low === undefined || low === high ? "" : `${number(low, 2)} … ${number(high, 2)}`;
}

// A value between its limits: the middle is zero, or the left end where it has one limit only.
function limit(id, value, bound, digits, unit, oneSided = false) {
  if (!Number.isFinite(value) || !Number.isFinite(bound)) { $(id).replaceChildren(); return; }
  const share = Math.max(-1, Math.min(1, value / bound)), from = oneSided ? 0 : 50, width = Math.abs(share) * (oneSided ? 100 : 50);
  $(id).classList.toggle("near", Math.abs(share) > 0.9);
  $(id).replaceChildren(make("div", { class: "limit-bar" }, make("i", { style: `left:${oneSided ? 0 : share < 0 ? from - width : from}%;width:${width}%` })),
    make("span", {}, `limit ${oneSided ? "" : "±"}${number(bound, digits)} ${unit}`));
}

const ROLES = { input_drive: "Input drive", load_drive: "Load drive" }, CIRCUITS = { emergency_stop: "Emergency stop", safe_torque_off: "Safe torque off" };
const GOOD_STATES = ["OPERATION_ENABLED", "SWITCH_ON_DISABLED", "READY_TO_SWITCH_ON", "SWITCHED_ON", "NOT_READY_TO_SWITCH_ON"];

function showCondition() {
  const now = state.condition, chip = (name, text, kind = "") => make("span", { class: `chip ${kind}` }, make("b", {}, name), ` ${text}`);
  const old = state.gone || Date.now() - heard > STALE_MS;
  if (!now || now.type === "unread" || old) {
    const why = state.gone ? "The service does not answer: drives, safety circuits and bus are not known." : now?.type === "unread" && !running() ? `Drives, safety circuits and bus: ${now.text}.`
      : "Drives, safety circuits and bus have not been read in the last seconds.";
    $("condition").replaceChildren(make("span", { class: "quiet" }, why));
    return;
  }
  const { cycles, bad, late_s: late, temperature_age_s: age } = now.bus;
  $("condition").replaceChildren(
    ...Object.entries(now.drives).map(([role, name]) => chip(ROLES[role] ?? role, name.replaceAll("_", " ").toLowerCase(), GOOD_STATES.includes(name) ? "" : "bad")),
    ...Object.entries(now.inputs).map(([name, demanded]) => chip(CIRCUITS[name] ?? name, demanded ? "demands a stop" : "closed", demanded ? "bad" : "")),
    ...(Object.keys(now.inputs).length ? [] : [chip("Safety circuits", "this bench has no input for them")]),
    chip("Bus", bad ? `${bad} of the last ${cycles} cycles wrong` : `the last ${cycles} cycles good${late === null ? "" : `, ${number(late * 1e6, 0)} µs late at most`}`, bad ? "bad" : ""),
    chip("Lubricant", age === null ? "never read" : `read ${number(age, 1)} s ago`, age === null ? "bad" : ""),
    make("span", { class: "quiet" }, now.source === "idle" ? "read without torque; nothing runs" : ""));
}

function draw() {
  if (!dirty || $("now").hidden || document.hidden) return;
  dirty = false;
  const seen = buffers.window(seconds, NAMES);
  if (!seen) return;
  const scale = DEGREES / state.about.ratio;
  const columns = (name, wanted, factor = 1) => [seen.time, wanted, ...seen[name].map(column => column.map(v => v === null ? null : v * factor))];
  // As long as less has been seen than is asked for, what there is fills the plot.
  const range = [Math.max(seen.end - seconds, Math.min(seen.time[0], seen.end - 30)), seen.end];
  const { limits } = state.about;
  plots.speed.limits = [limits.motor_speed * scale, -limits.motor_speed * scale];
  plots.torque.limits = [limits.load_torque, -limits.load_torque];
  plots.temperature.limits = [limits.temperature];
  plots.speed.show(columns("motor_velocity", seen.motor_velocity_setpoint[2].map(v => v * scale), scale), range);
  plots.torque.show(columns("load_torque", seen.load_motor_torque_setpoint[2]), range);
  const way = state.status.phase === "heating" ? state.status.way : null;
  plots.temperature.show(withWay(columns("temperature", seen.time.map(() => null)), way), way ? [range[0], Math.max(range[1], way[way.length - 1][0])] : range);
}

// The expected way reaches into the future: its times are added where nothing has been measured yet.
function withWay([time, , low, high, mean], way) {
  if (!way || way.length < 2) return [time, time.map(() => null), low, high, mean];
  const at = t => {
    if (t < way[0][0] || t > way[way.length - 1][0]) return null;
    const i = Math.max(1, way.findIndex(([when]) => when >= t));
    const [[t0, v0], [t1, v1]] = [way[i - 1], way[i]];
    return v0 + (v1 - v0) * (t - t0) / Math.max(1e-9, t1 - t0);
  };
  const later = way.filter(([when]) => when > time[time.length - 1]);
  const none = later.map(() => null);
  return [[...time, ...later.map(([when]) => when)], [...time.map(at), ...later.map(([, v]) => v)], [...low, ...none], [...high, ...none], [...mean, ...none]];
}

export function spectrum() {
  const message = state.spectrum;
  if (!message?.amplitude) {
    $("te-text").textContent = message ? `${Math.floor(100 * message.share)} % of a revolution seen; the transmission error appears with the whole.` : "The transmission error appears after a whole revolution of steady motion.";
    // what an earlier revolution looked like is not what the text names
    $("model-text").textContent = "";
    plots.spectrum.show([[], [], []], plots.spectrum.range);
    plots.curve.show([[], [], [], [], []]);
    return;
  }
  $("te-text").textContent = `Transmission error ${number(message.rms * 1e6, 1)} µrad RMS at ${number(message.torque, 0)} N·m, ${number(message.velocity * DEGREES, 1)} °/s, ${number(message.temperature, 1)} °C${message.at ? `, ${message.what.replaceAll("_", " ")}, the revolution that ended at ${clock(message.at)} bench time` : ""}.`;
  $("model-text").textContent = modelText(message);
  showSpectrum(plots.spectrum, plots.curve, message);
}

const DUE = { reset: "acknowledged; next: reset the bench", resume: "reset; the next start gives torque again" };
const ENDS = { finished: "is finished", failed_points: "is finished, but not every point passed", interrupted: "was stopped by the operator", refused: "was refused", tripped: "was stopped by a limit or a fault" };
const PHASES = { free: "Ready", opening: "Opening the bench", measuring_zero: "Measuring the zero", measuring: "Measuring", heating: "Warming up", paused: "Paused", stopping: "Stopping", resetting: "Resetting", by_hand: "Moved by hand", taring: "Taring", ended: "Finishing" };

export function status() {
  const { status: now } = state, run = running(), box = $("phase");
  if (state.gone) {
    box.className = "phase alarm";
    $("phase-name").textContent = "Not known";
    $("phase-label").textContent = "the service does not answer";
    return;
  }
  const phase = run ? now.phase : "free";
  const alarm = state.alarms.length && !run, due = run ? "" : state.latch?.due;
  box.className = `phase ${alarm ? "alarm" : due ? "paused" : phase}`;
  $("phase-name").textContent = alarm || due === "acknowledge" || due === "reset" ? "Stopped" : PHASES[phase] ?? phase;
  $("phase-label").textContent = run ? (now.pausing ? "pauses after this point · " : "") + (now.label || run.title).replaceAll("_", " ") : alarm ? "see the alarm" : DUE[due] ? DUE[due] : state.held && state.runs.some(r => r.state === "queued") ? "the queue is held" : "nothing runs";
  progress(run, now);
  // the phase as well: “Do not pause” is “Go on” as soon as it has paused
  const signature = JSON.stringify([state.allowed, phase, Boolean(run), run?.id, [...state.points.values()].map(p => p.state).join(), state.runs.map(one => one.state).join()]);
  if (signature !== lastAct) { lastAct = signature; $("acts").replaceChildren(...buttons()); }
}

function progress(run, now) {
  const points = [...state.points.values()], over = points.filter(p => ["done", "failed", "skipped", "saving"].includes(p.state)).length;
  if (!run) {
    const last = state.runs.filter(one => one.state === "ended" && !one.resets && one.end.kind !== "withdrawn").pop();
    $("progress-text").textContent = "No campaign runs";
    $("progress-rest").textContent = last ? `The last one ${ENDS[last.end.kind] ?? `ended: ${last.end.text}`}` : "";
    $("progress-bar").style.width = "0";
    return;
  }
  const total = state.plan?.duration_s, rest = now.remaining_s;
  $("progress-text").textContent = points.length ? `Point ${Math.min(over + 1, points.length)} of ${points.length} · ${run.title}` : run.title;
  $("progress-rest").textContent = Number.isFinite(rest) ? `${duration(rest)} left${run.real_time || !state.about.emulated ? `, until ${clock(Date.now() / 1000 + rest)}` : " (bench time)"}` : "";
  $("progress-bar").style.width = `${total ? Math.max(0, Math.min(100, 100 * (1 - rest / total))) : 0}%`;
}
