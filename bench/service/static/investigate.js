// Investigations: what a report leaves open is asked of the bench. Budget first, then each experiment with its points.

import { get, post } from "./api.js";
import { sheet, simple } from "./acts.js";
import { planSum, taskTable } from "./plan.js";
import { may, me, state } from "./state.js";
import { DEGREES, make, number, pill } from "./text.js";

export function ask(one) {
  const field = (label, value, more = {}) => { const input = make("input", { type: "number", value, ...more }); return [make("label", { class: "field" }, label, input), input]; };
  const [hours, hoursOf] = field("Budget of bench time, h", 2, { min: 0, max: 1000, step: "any", id: "ask-hours" });
  const [count, countOf] = field("At most so many experiments", 3, { min: 0, max: 100, id: "ask-experiments" });
  const [sure, sureOf] = field("Confidence that each finding needs", 0.7, { min: 0, max: 0.9, step: 0.05 });
  const who = make("input", { type: "text", maxlength: 40, value: me.name });
  const alone = make("input", { type: "checkbox" }), pace = make("input", { type: "checkbox" });
  sheet(`Investigate ${one.folder}`, [
    make("p", {}, "The recordings are analysed again. Then an experiment is designed that distinguishes the open explanations. Its points, its time and the expected result are shown. Nothing moves until the person who holds the controls lets it begin."),
    hours, count, sure,
    state.about.may_go_alone ? make("label", { class: "option" }, alone, make("span", {}, "Experiments after the first begin by themselves")) : make("p", { class: "quiet" }, "On this bench every experiment waits for that yes."),
    state.about.emulated ? make("label", { class: "option" }, pace, make("span", {}, "At the clock's pace", make("small", {}, "as on a real bench"))) : null,
    me.name ? null : make("label", { class: "field" }, "Your name, for the record", who),
  ].filter(Boolean), [["Design the first experiment", async () => {
    me.name = who.value.trim() || me.name;
    const investigation = { hours: Number(hoursOf.value), experiments: Number(countOf.value), confidence: Number(sureOf.value), alone: alone.checked, real_time: pace.checked };
    await post("analyses", { name: me.name, kind: "investigate", folder: one.folder, investigation });
  }]]);
}

// The experiment that waits, or runs: its points and time, and the two answers.
export function waiting(one) {
  if (!one.asks?.plan) return [];
  const run = state.runs.find(other => other.id === one.asks.run), open = run?.state === "proposed";
  return [make("div", { class: "experiment" },
    make("div", { class: "line" }, make("h2", {}, `Experiment ${one.asks.number}`), run ? pill(run.state) : null),
    make("p", {}, planSum(one.asks.plan)), make("div", { class: "scroll" }, taskTable(one.asks.plan)),
    open ? make("div", { class: "acts" },
      make("button", { type: "button", class: "main", disabled: !may("approve"), on: { click: () => simple(`runs/${run.id}/approve`) } }, "Let it begin"),
      make("button", { type: "button", on: { click: () => simple(`runs/${run.id}/withdraw`) } }, "Refuse")) : null)];
}

const gain = value => value === null || value === undefined ? "not computed" : number(value, 1);
const point = one => [one.kind, `${number(one.load_torque, 0)} N·m`, `${number(one.velocity * DEGREES, 1)} °/s`, one.temperature === undefined ? "" : `${number(one.temperature, 1)} °C`].filter(Boolean).join(", ").replaceAll("_", " ");

function step(one) {
  const head = ["Question", "Open because", "Expected gain", "What came", "Became"], cell = text => make("td", {}, text);
  return [make("h3", {}, `Experiment ${one.number}: ${one.why}`),
    make("p", {}, `${one.state}; expected ${number(one.expected_h, 2)} h of bench time, ${one.took_h === null ? "not run yet" : `took ${number(one.took_h, 2)} h`}. Points: ${one.points.map(point).join("; ")}.`),
    make("div", { class: "scroll" }, make("table", {}, make("thead", {}, make("tr", {}, ...head.map(name => make("th", {}, name)))),
      make("tbody", {}, ...one.questions.map(row => make("tr", {}, cell([row.effect, ...row.rivals].join(" or ")), cell(row.why), cell(gain(row.expected_gain)), cell(gain(row.came)), cell(row.became))))))];
}

// Steps and log of an investigation, fetched again whenever it has said something new.
const shown = new Map();
export function steps(one) {
  const place = make("div", { class: "steps" }, ...(shown.get(one.id)?.parts ?? []));
  if (shown.get(one.id)?.what === one.what + one.state) return place;
  get(`analyses/${one.id}/steps`).then(({ log, said }) => {
    const parts = [...(log.steps ?? []).flatMap(step), log.ended ? make("p", {}, `Ended: ${log.ended}. ${number(log.hours, 2)} h of bench time.`) : null,
      ...(log.bench_would_need ?? []).map(text => make("p", {}, `The bench would need: ${text}`)),
      make("details", {}, make("summary", {}, `What it said (${said.length} lines)`), make("pre", {}, said.join("\n")))].filter(Boolean);
    shown.set(one.id, { what: one.what + one.state, parts });
    document.querySelector(`[data-analysis="${CSS.escape(one.id)}"] .steps`)?.replaceChildren(...parts);
  }).catch(error => place.replaceChildren(make("p", { class: "problem" }, error.message)));
  return place;
}
