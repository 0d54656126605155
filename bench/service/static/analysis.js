// The view "Analysis": progress of identifications and mismatch reports, their reports and models.

import { get, post } from "./api.js";
import { doIt, sentence, start, withControls } from "./acts.js";
import * as investigate from "./investigate.js";
import { may, me, state } from "./state.js";
import { $, make, moment, pill } from "./text.js";

const TITLES = { identify: "Identification", mismatch: "What the simulation leaves out", investigate: "Investigation", compare: "Before and since" };

export function open() {
  $("report-close").addEventListener("click", () => { $("report-card").hidden = true; $("report").removeAttribute("src"); });
}

export function analyses() {
  $("analyses").replaceChildren(...(state.analyses.length ? state.analyses.map(card) : [make("p", { class: "quiet" }, "There are none yet.")]));
}

function card(one) {
  const button = (label, click, kind = "") => make("button", { type: "button", class: kind, on: { click } }, label);
  const live = ["waiting", "running"].includes(one.state);
  const drawn = state.model && state.model.includes(one.id);
  const bar = make("i");
  bar.style.width = `${Math.round(100 * one.share)}%`;
  return make("div", { class: "card", "data-analysis": one.id },
    make("div", { class: "line" }, make("h2", {}, `${TITLES[one.kind]}: ${one.folder}`), pill(one.state)),
    make("p", {}, one.what), live ? make("div", { class: "bar" }, bar) : null,
    make("p", { class: "quiet" }, `${one.by}, ${moment(one.asked_at)}`),
    ...(one.kind === "investigate" ? [...investigate.waiting(one), investigate.steps(one)] : []),
    one.open ? make("p", {}, `${one.open} ${one.open === 1 ? "finding is" : "findings are"} ambiguous, unknown, or not sure.`) : null,
    make("div", { class: "acts" },
      one.has_report ? button("Read the report", () => report(one), "main") : null,
      one.has_model && one.kind === "identify" && !drawn ? button("Draw over the spectrum", () => doIt(() => post("model", { analysis: one.id }))) : null,
      drawn ? button("Draw no model", () => doIt(() => post("model", { analysis: null }))) : null,
      one.open ? button("Investigate what is open", () => investigate.ask(one), "main") : null,
      ...one.next.map((name, i) => make("button", { type: "button", disabled: !may("start"), on: { click: () => withControls(() => start(name)) } }, `Run the next experiment${one.next.length > 1 ? ` ${i + 1}` : ""}`)),
      live ? button(one.kind === "investigate" ? "End the investigation" : "Cancel", () => doIt(() => post(`analyses/${one.id}/cancel`, { name: me.name || "somebody" }))) : null));
}

let read = null;
function report(one) {
  read = one.id;
  $("report-card").hidden = false;
  $("report-title").textContent = `${TITLES[one.kind]}: ${one.folder}`;
  $("report-since").replaceChildren();
  // an identification says in its own report what changed
  if (one.kind === "mismatch") get(`analyses/${one.id}/since`)
    // whoever reads another one by now is not told of this one
    .then(lines => { if (read === one.id) $("report-since").replaceChildren(...lines.map(line => make("p", {}, line))); })
    .catch(error => { if (read === one.id) $("report-since").textContent = sentence(error); });
  $("report").src = `/api/analyses/${one.id}/report`;
  $("report-card").scrollIntoView({ behavior: "smooth", block: "start" });
}
