// The view "Trends": one gearbox over its campaigns, a chart a quantity with its limits of control.

import { get, post } from "./api.js";
import { doIt, sentence } from "./acts.js";
import { head } from "./find.js";
import { me } from "./state.js";
import { $, make, pill } from "./text.js";

const SVG = "http://www.w3.org/2000/svg", W = 420, H = 170, LEFT = 62, RIGHT = 10, TOP = 10, BOTTOM = 26;
let shown = null, asked = 0;

export function open() {
  for (const id of ["trend-gearbox", "trend-since"]) $(id).addEventListener("change", load);
  $("trend-identify").addEventListener("click", identify);
  $("trend-csv").addEventListener("click", save);
}

export async function show() {
  try {
    const known = await get("gearboxes"), chosen = $("trend-gearbox").value;
    $("trend-gearbox").replaceChildren(...known.map(one => make("option", { value: one.serial }, `${one.serial || "without a serial number"} (${one.campaigns} campaign${one.campaigns === 1 ? "" : "s"})`)));
    if (known.some(one => one.serial === chosen)) $("trend-gearbox").value = chosen;
    if (known.length) await load(); else problem("There are no recordings yet.");
  } catch (error) { problem(sentence(error)); }
}

function problem(text) {
  $("trend-problem").textContent = text;
  if (text) { $("trend-lines").replaceChildren(); $("trend-card").hidden = true; $("trend-campaigns").replaceChildren(); $("trend-csv").disabled = true; $("trend-identify").hidden = true; }
}

async function load() {
  const mine = ++asked, asks = new URLSearchParams({ gearbox: $("trend-gearbox").value });
  if ($("trend-since").value) asks.set("since", $("trend-since").value);
  try {
    const found = await get(`trend?${asks}`);
    if (mine !== asked) return;
    problem("");
    draw(found);
  } catch (error) { if (mine === asked) problem(sentence(error)); }
}

function draw(found) {
  shown = found;
  const missing = found.campaigns.filter(one => one.state === "not yet");
  $("trend-lines").replaceChildren(...found.lines.map(text => make("p", { class: "big" }, text)));
  $("trend-identify").hidden = !missing.length;
  $("trend-csv").disabled = !found.series.length;
  $("trend-card").hidden = !found.series.length;
  $("trend-text").textContent = `${found.reference ? `Without load at ${found.reference.speed_deg_s} °/s and ${found.reference.temperature_degc} °C. ` : ""}Bars: two standard deviations of the identification. Shaded: limits from the campaigns before, widened by the campaign's own uncertainty; three are needed. A square is outside of them.`;
  const order = one => [one.points[one.points.length - 1].outside ? 0 : 1, found.changed.some(c => c.key === one.key && c.changed) ? 0 : 1];
  const sorted = found.series.map((one, i) => [...order(one), i, one]).sort((a, b) => a[0] - b[0] || a[1] - b[1] || a[2] - b[2]).map(row => row[3]);
  $("trend-charts").replaceChildren(...sorted.map(chart));
  $("trend-campaigns").replaceChildren(make("table", {}, head("Campaign", "Begun", "Recordings", ""), make("tbody", {}, ...[...found.campaigns].reverse().map(one => make("tr", {},
    make("td", {}, one.title, one.title === one.folder ? null : make("small", { class: "quiet" }, ` ${one.folder}`)), make("td", {}, day(one.started_s)), make("td", { class: "number" }, String(one.recordings)),
    make("td", {}, pill({ identified: "done", impossible: "failed" }[one.state] ?? "", one.state), one.why ? make("small", { class: "quiet" }, ` ${one.why}`) : null))))));
}

const day = seconds => new Date(seconds * 1000).toLocaleDateString("sv");
const element = (tag, attributes, ...content) => {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...content);
  return made;
};
const short = value => Number(value.toPrecision(4)).toString().replace("-", "−");

function chart(one) {
  const { points } = one, last = points[points.length - 1];
  const ends = points.flatMap(p => [p.value - 2 * p.std, p.value + 2 * p.std]);
  const span = Math.max(...ends) - Math.min(...ends);
  // limits that are wide for want of campaigns do not make the values a line
  const near = p => p.limits ? [Math.max(p.limits.lower, Math.min(...ends) - span), Math.min(p.limits.upper, Math.max(...ends) + span)] : [];
  const all = [...ends, ...points.flatMap(near)], low = Math.min(...all), high = Math.max(...all), room = (high - low || Math.abs(high) || 1) * 0.06;
  const [t0, t1] = [points[0].started_s, last.started_s];
  const x = t => t1 === t0 ? (LEFT + W - RIGHT) / 2 : LEFT + 8 + (t - t0) / (t1 - t0) * (W - LEFT - RIGHT - 16);
  const y = v => Math.min(H - BOTTOM, Math.max(TOP, TOP + (high + room - v) / (high - low + 2 * room) * (H - TOP - BOTTOM)));
  const text = `${one.name}: last ${short(last.value)} ± ${last.std.toPrecision(2)} ${one.unit}, ${points.length} campaign${points.length === 1 ? "" : "s"}${last.limits ? `, limits ${short(last.limits.lower)} to ${short(last.limits.upper)}` : ", no limits yet"}${last.outside ? ", OUTSIDE" : ""}`;
  const svg = element("svg", { viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": text, class: "trend" });
  for (const v of [low, (low + high) / 2, high]) svg.append(element("line", { x1: LEFT, x2: W - RIGHT, y1: y(v), y2: y(v), class: "grid" }), element("text", { x: LEFT - 6, y: y(v) + 4, "text-anchor": "end" }, short(v)));
  points.forEach((p, i) => {
    if (!p.limits) return;
    const from = i ? (x(points[i - 1].started_s) + x(p.started_s)) / 2 : LEFT, to = i + 1 < points.length ? (x(p.started_s) + x(points[i + 1].started_s)) / 2 : W - RIGHT;
    svg.append(element("rect", { x: from, width: Math.max(1, to - from), y: y(p.limits.upper), height: Math.max(1, y(p.limits.lower) - y(p.limits.upper)), class: "limits" }),
      element("line", { x1: from, x2: to, y1: y(p.limits.centre), y2: y(p.limits.centre), class: "centre" }));
  });
  svg.append(element("polyline", { points: points.map(p => `${x(p.started_s)},${y(p.value)}`).join(" "), class: "way" }));
  for (const p of points) {
    const cx = x(p.started_s), told = element("title", {}, `${p.folder}, ${day(p.started_s)}: ${short(p.value)} ± ${p.std.toPrecision(2)} ${one.unit}`);
    svg.append(element("line", { x1: cx, x2: cx, y1: y(p.value + 2 * p.std), y2: y(p.value - 2 * p.std), class: "bar" }),
      p.outside ? element("rect", { x: cx - 6, y: y(p.value) - 6, width: 12, height: 12, class: "outside" }, told) : element("circle", { cx, cy: y(p.value), r: 4.5, class: "dot" }, told));
  }
  svg.append(element("text", { x: LEFT, y: H - 6 }, day(t0)));
  if (t1 !== t0) svg.append(element("text", { x: W - RIGHT, y: H - 6, "text-anchor": "end" }, day(t1)));
  return make("figure", { "data-key": one.key, class: last.outside ? "outside" : "" }, make("figcaption", {}, make("b", {}, one.name), ` ${short(last.value)} ± ${last.std.toPrecision(2)} ${one.unit} `, last.outside ? pill("failed", "outside") : null), svg);
}

async function identify() {
  const name = me.name || "somebody";
  const missing = shown.campaigns.filter(one => one.state === "not yet");
  for (const one of missing) if (!await doIt(() => post("analyses", { name, kind: "identify", folder: one.folder }), `${missing.length} identification${missing.length === 1 ? "" : "s"} wait under Analysis; come back when they are done`)) return;
}

function save() {
  const rows = [["quantity", "unit", "campaign", "begun", "value", "standard_deviation", "lower_limit", "centre", "upper_limit", "outside"]];
  for (const one of shown.series) for (const p of one.points) rows.push([one.name, one.unit, p.folder, new Date(p.started_s * 1000).toISOString(), p.value, p.std, p.limits?.lower ?? "", p.limits?.centre ?? "", p.limits?.upper ?? "", p.outside]);
  const text = rows.map(row => row.map(cell => typeof cell === "string" ? `"${cell.replaceAll('"', '""')}"` : cell).join(",")).join("\n");
  make("a", { href: URL.createObjectURL(new Blob([`${text}\n`], { type: "text/csv" })), download: `trend-${shown.gearbox || "gearbox"}.csv` }).click();
}
