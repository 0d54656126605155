// The view "Campaign": the queue, every point with state and quality, the lubricant's planned way and the measured one.

import * as acts from "./acts.js";
import { bandPlot } from "./charts.js";
import { buffers } from "./now.js";
import { may, state, unfinished } from "./state.js";
import { $, DEGREES, duration, make, moment, number, pill } from "./text.js";

const UNTOUCHED_MS = 30000;
let plot, drawn = "", touched = 0;
const rows = new Map();

export function open() {
  plot = bandPlot($("plot-way"), { title: "°C over bench time", set: "planned", least: 0.5, height: 230 });
  setInterval(way, 1000);
  // Whoever looks for a point is not to be scrolled away from it.
  for (const event of ["wheel", "touchstart", "pointerdown", "keydown"]) $("points").addEventListener(event, () => { touched = Date.now(); }, { passive: true });
}

export function queue() {
  const waiting = state.runs.filter(run => ["proposed", "queued"].includes(run.state));
  // whoever looks at another view is told that somebody waits for an answer
  const asked = state.runs.filter(run => run.state === "proposed").length;
  document.querySelector("#tabs [data-view=campaign]").replaceChildren("Campaign", ...(asked ? [make("small", { class: "badge" }, `${asked} to decide`)] : []));
  const rest = [...state.runs].reverse().filter(run => !waiting.includes(run)).slice(0, 6);
  $("queue-acts").replaceChildren(...(may("queue") ? [make("button", { type: "button", class: "main", on: { click: () => acts.simple("queue/go-on") } }, "Let the queue go on")] : []));
  const row = run => make("tr", { class: run.state === "running" ? "current" : "" },
    make("td", {}, pill(run.state)), make("td", {}, run.title), make("td", {}, run.by), make("td", {}, moment(run.asked_at)),
    make("td", {}, run.end?.text || (run.end?.kind ?? "").replace("_", " ")),
    make("td", {}, make("div", { class: "acts" }, ...offers(run))));
  $("queue").replaceChildren(waiting.length + rest.length ? make("table", {}, head("State", "Campaign", "Asked for by", "At", "Ended", ""), make("tbody", {}, ...waiting.map(row), ...rest.map(row)))
    : make("p", { class: "quiet" }, "Nothing has been run yet. “Start a campaign” is on the page Now; bench run in a shell joins this queue."));
}

function offers(run) {
  const button = (label, click, kind = "") => make("button", { type: "button", class: kind, on: { click } }, label);
  if (run.state === "proposed") return [button("Let it begin", () => acts.simple(`runs/${run.id}/approve`), "main"), button("Refuse", () => acts.simple(`runs/${run.id}/withdraw`))];
  if (run.state === "queued") return [button("Take out", () => acts.simple(`runs/${run.id}/withdraw`))];
  if (may("again") && unfinished().includes(run)) return [button("Go on", () => acts.again(run))];
  return [];
}

const head = (...names) => make("thead", {}, make("tr", {}, ...names.map(name => make(name ? "th" : "td", {}, name))));

// A point whose motion was stopped was not judged: it is cut short, as on the page of recordings.
const shownAs = point => point.state === "failed" && point.complete === false ? "cut short" : point.state;

export function points() {
  const list = [...state.points.values()];
  $("points-title").textContent = state.plan ? `Points of ${state.plan.campaign}` : "Points";
  const count = one => list.filter(p => shownAs(p) === one).length;
  $("points-count").textContent = list.length ? `${count("done")} done, ${count("failed")} not passed, ${count("cut short")} cut short, ${count("skipped")} skipped, ${list.length - count("done") - count("failed") - count("cut short") - count("skipped")} to come · ${duration(state.status.remaining_s)} left` : "";
  const key = list.map(p => p.identity).join();
  if (key !== drawn) {
    drawn = key;
    rows.clear();
    const body = make("tbody");
    for (const one of list) { const tr = make("tr"); rows.set(one.identity, tr); body.append(tr); }
    $("points").replaceChildren(list.length ? make("table", {}, head("", "State", "Measurement", "N·m", "°/s", "°C", "Time", "Quality", ""), body) : make("p", { class: "quiet" }, "The points appear when a campaign runs."));
    for (const one of list) row(one);
  }
}

// What may be done has changed: the rows stay, their buttons follow.
export function enable() {
  for (const button of $("points").querySelectorAll("button[data-act]")) button.disabled = !may(button.dataset.act);
}

export function point(one) { points(); row(one); }

function row(one) {
  const tr = rows.get(one.identity);
  if (!tr) return;
  const now = ["running", "heating"].includes(one.state);
  if (now && tr.className !== "current" && !$("campaign").hidden && Date.now() - touched > UNTOUCHED_MS) $("points").scrollTo({ top: tr.offsetTop - $("points").clientHeight / 2 });
  tr.className = now ? "current" : "";
  const again = ["done", "failed", "skipped"].includes(one.state);
  const cell = (value, digits, unit) => make("td", { class: "number", "data-unit": value === null ? "" : unit }, value === null ? "as found" : number(value, digits));
  tr.replaceChildren(
    make("td", { class: "number" }, String(one.number)), make("td", {}, pill(shownAs(one))),
    make("td", {}, one.sequence.replaceAll("_", " "), one.stage ? make("small", { class: "quiet" }, ` ${one.stage}`) : null),
    cell(one.load_torque, 0, "N·m"), cell(one.velocity * DEGREES, 1, "°/s"), cell(one.temperature, 1, "°C"),
    make("td", { class: "number" }, duration(one.duration_s)), make("td", {}, quality(one)),
    make("td", {}, make("div", { class: "acts" }, make("button", { type: "button", "data-act": again ? "repeat" : "skip", disabled: !may(again ? "repeat" : "skip"), on: { click: () => acts.point(again ? "repeat" : "skip", state.points.get(one.identity)) } }, again ? "Repeat" : "Skip"))),
  );
}

function quality(one) {
  if (one.note) return one.note;
  const q = one.quality;
  if (!q || one.state !== "done") return one.take > 1 ? `take ${one.take}` : "";
  // Each check of the quality gate: how much of what is allowed was used, of both sides the greater.
  const used = Object.entries(q).filter(([, check]) => check.value !== null && check.low !== null && check.high !== null && check.high > check.low)
    .map(([name, check]) => [name, Math.abs(check.value - (check.low + check.high) / 2) / ((check.high - check.low) / 2)]);
  const worst = used.sort((a, b) => b[1] - a[1])[0];
  // What nobody looked at is not said to be good.
  const made = Object.values(q).filter(check => check.passed !== null), all = Object.keys(q).length;
  const lost = q.lost_cycles?.value ? `${q.lost_cycles.value} cycles lost` : q.lost_cycles?.value === 0 ? "no cycle lost" : "";
  const some = made.length < all ? `${made.length} of ${all} checks made` : "";
  return [one.take > 1 ? `take ${one.take}` : "", worst ? `${worst[0].replaceAll("_", " ")} at ${number(100 * worst[1], 0)} % of its band` : "", lost, some].filter(Boolean).join(", ");
}

// Planned way from the beginning to the end, measured temperature so far.
function way() {
  if ($("campaign").hidden || document.hidden || !state.plan?.began) return;
  const seen = buffers.window(14 * 3600, ["temperature"]);
  const planned = state.plan.way.map(([t, v]) => [state.plan.began + t, v]);
  const measured = seen ? seen.time.map((t, i) => [t, seen.temperature[0][i], seen.temperature[1][i], seen.temperature[2][i]]) : [];
  const times = [...new Set([...planned.map(([t]) => t), ...measured.map(([t]) => t)])].sort((a, b) => a - b);
  const plans = new Map(planned), seens = new Map(measured.map(m => [m[0], m]));
  const columns = [times, times.map(t => plans.get(t) ?? null)];
  for (const i of [1, 2, 3]) columns.push(times.map(t => seens.get(t)?.[i] ?? (plans.has(t) ? undefined : null)));
  plot.show(columns, [times[0], times[times.length - 1]]);
}
