// Two recordings side by side in three lines: what their plots show, in numbers. The earlier one stands first.

import { $, DEGREES, make, moment, number } from "./text.js";

const MICRO = 1e6, MOST_ORDERS = 3;
const MEANS = [["motor torque", "motor_torque", 1, 2, "N·m"], ["load torque", "torque", 1, 1, "N·m"], ["speed", "velocity", DEGREES, 2, "°/s"], ["lubricant", "temperature", 1, 1, "°C"]];

const LEAST_PERCENT = 0.05; // what is less is written as 0.0
const percent = (before, after) => {
  if (!(before > 0 && after < 2 * before)) return "";
  const change = (after / before - 1) * 100;
  return Math.abs(change) < LEAST_PERCENT ? " (less than 0.1 % apart)" : ` (${change > 0 ? "+" : "−"}${number(Math.abs(change), 1)} %)`;
};
const known = value => value !== null && value !== undefined;

// Each is { one, folder, data, turn }: the recording, its plots, and its revolution as the service gives it.
export function changes(first, second) {
  const [before, after] = [first, second].sort((a, b) => Date.parse(a.data.started_at) - Date.parse(b.data.started_at));
  const [a, b] = [before.turn, after.turn];
  const orders = a.amplitude.map((value, i) => [i + 1, value * MICRO, b.amplitude[i] * MICRO]).sort((x, y) => Math.abs(y[2] - y[1]) - Math.abs(x[2] - x[1])).slice(0, MOST_ORDERS);
  const means = MEANS.filter(([, key]) => known(a[key]) && known(b[key])).map(([name, key, scale, digits, unit]) => `${name} ${number(a[key] * scale, digits)} → ${number(b[key] * scale, digits)} ${unit}`);
  return make("div", { id: "changes" },
    make("h2", {}, `What changed: ${before.folder}, ${moment(before.data.started_at)} → ${after.folder}, ${moment(after.data.started_at)}`),
    make("p", {}, `Transmission error ${number(a.rms * MICRO, 1)} → ${number(b.rms * MICRO, 1)} µrad RMS${percent(a.rms, b.rms)}.`),
    make("p", {}, `Orders that changed most: ${orders.map(([order, x, y]) => `${order}: ${number(x, 2)} → ${number(y, 2)} µrad`).join("; ")}.`),
    means.length ? make("p", {}, `Means: ${means.join("; ")}.`) : null,
    make("p", { class: "quiet" }, "These are numbers of two single recordings. The page Trends shows whether a difference is more than scatter."));
}

// The search, narrowed down to what can be compared with a recording: its gearbox, at its set point.
export function lookForLike(one, gearbox, then) {
  const fields = { gearbox, kind: one.kind, load_torque: one.load_torque, velocity: known(one.velocity) ? one.velocity * DEGREES : null, temperature: null, words: "" };
  for (const [name, value] of Object.entries(fields)) $(`q-${name}`).value = known(value) ? (typeof value === "number" ? String(Number(value.toPrecision(6))) : value) : "";
  then();
}
