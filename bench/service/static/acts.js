// Acts of the operator: sheets that ask, the controls. Sheets are never modal: STOP stays in reach.
// An act names the run (and point) that was on the page when it was asked for: it is refused for another.

import { get, newId, post, Refused } from "./api.js";
import { jog, tare } from "./jog.js";
import { may, me, running, state, unfinished } from "./state.js";
import { $, duration, make, moment, number, toast } from "./text.js";

let ask;
// What an act of a sheet returns whose answer stands in the sheet itself: it stays open.
export const STAY = Symbol("stay");

// Opens a sheet; `act` gets the form's values and may refuse with an error, whose sentence is shown.
export function sheet(title, body, buttons) {
  $("sheet-title").textContent = title;
  $("sheet-body").replaceChildren(...body);
  $("sheet-problem").textContent = "";
  const close = () => $("sheet").close();
  $("sheet-acts").replaceChildren(
    ...buttons.map(([label, act, kind = "main"]) => make("button", { type: "button", class: kind, on: { click: async event => {
      event.target.disabled = true;
      try {
        const answer = await act();
        if (answer?.done) toast(answer.done);
        if (answer !== STAY) close();
      } catch (error) { $("sheet-problem").textContent = sentence(error); }
      event.target.disabled = false;
    } } }, label)),
    make("button", { type: "button", on: { click: close } }, "Close"),
  );
  if (!$("sheet").open) $("sheet").show();
  $("sheet-body").querySelector("input")?.focus();
}

export const sentence = error => error instanceof Refused ? error.message : "The service cannot be reached; nothing was changed.";

export async function doIt(act, said) {
  try { const answer = await act(); toast(said ?? answer.done ?? "done"); return answer; } catch (error) { toast(sentence(error)); return null; }
}

// -- the controls -------------------------------------------------------------------------------------------------------

const nameField = () => make("label", { class: "field" }, "Your name, for the record",
  make("input", { type: "text", id: "name", maxlength: 40, autocomplete: "name", value: me.name }));

async function take(from = null) {
  const name = $("name").value.trim();
  const answer = await post("controls/take", from ? { name, taken_from: from } : { name });
  me.name = name;
  me.hold(answer.secret, answer.id);
  // The stream may say so before this answer or after it.
  state.holder = { id: answer.id, name, since: new Date().toISOString(), away: false, offered_to: null };
  document.dispatchEvent(new Event("controls"));
  toast(`${name} holds the controls`);
}

export function controls(then = null) {
  ask = then;
  const holder = state.holder;
  const after = async () => { const next = ask; ask = null; if (next) { setTimeout(next, 0); } };
  if (me.holds) {
    const to = make("input", { type: "text", maxlength: 40 });
    return sheet("You hold the controls", [
      make("p", {}, "What you start continues if you release them. Everybody can press STOP."),
      make("label", { class: "field" }, "Hand over to (name)", to),
    ], [
      ["Hand over", () => post("controls/offer", { secret: me.secret, to: to.value.trim() })],
      ["Let go", async () => { await post("controls/release", { secret: me.secret }); me.letGo(); document.dispatchEvent(new Event("controls")); }, ""],
    ]);
  }
  if (!holder) return sheet("Take the controls", [make("p", {}, "One person at a time holds them; the others watch. Everybody can press STOP."), nameField()],
    [["Take the controls", async () => { await take(); await after(); }]]);
  const offered = holder.offered_to;
  return sheet(`${holder.name} holds the controls`, [
    make("p", {}, offered ? `${holder.name} offers them to ${offered}.` : `Since ${new Date(holder.since).toLocaleTimeString([], { hour12: false })}${holder.away ? ", but the page has not been heard of for a minute" : ""}. Ask first; taking them is written into the record book.`),
    nameField(),
  ], [[offered ? "Accept" : `Take them from ${holder.name}`, async () => { await take(offered && offered === $("name").value.trim() ? null : holder.name); await after(); }, offered ? "main" : "hard"]]);
}

export const withControls = act => me.holds ? act() : controls(act);
const held = more => ({ secret: me.secret, ...more });
const current = () => running()?.id ?? "";
const last = () => state.runs.filter(run => run.state === "ended" && run.end?.kind !== "withdrawn").pop()?.id ?? null;

setInterval(() => {
  if (me.holds) post("controls/keep", { secret: me.secret }, { id: false }).catch(error => { if (error instanceof Refused) me.letGo(); });
}, 20000);

// -- a campaign ---------------------------------------------------------------------------------------------------------

export async function start(first = null) {
  const offered = await doIt(() => get("campaigns"), "");
  if (!offered) return;
  $("toast").hidden = true;
  const radios = (name, options, wanted = null) => options.map(([value, label, note, disabled], i) => make("label", { class: "option" },
    make("input", { type: "radio", name, value, checked: value === wanted || (i === 0 && !wanted), disabled }), make("span", {}, label, make("small", {}, note))));
  const plan = make("p", { class: "quiet" }, " ");
  const pace = state.about.emulated ? radios("pace", [["clock", "At the clock's pace", "as on a real bench"], ["fast", "As fast as the computer can", "hours of bench time in minutes"]]) : [];
  const choices = radios("campaign", offered.map(c => [c.name, c.title, c.problem ?? c.name, Boolean(c.problem)]), first);
  const models = state.analyses.filter(one => one.has_model && one.state === "done");
  const pauses = make("input", { type: "checkbox", name: "twin_pause" });
  const twins = models.length ? [make("h2", {}, "Watched by"), ...radios("twin", [["", "No model", "nothing is compared while it runs"],
    ...models.map(one => [one.id, `The model of ${one.folder}`, `${one.kind === "identify" ? "identified" : "from a mismatch report"}, ${moment(one.asked_at)}`])]),
  make("label", { class: "option" }, pauses, make("span", {}, "Begin no further point when it no longer holds"))] : [];
  const body = [...choices, plan, ...(pace.length ? [make("h2", {}, "Pace"), ...pace] : []), ...twins];
  const chosen = name => document.querySelector(`#sheet-body input[name=${name}]:checked`)?.value;
  const look = async () => {
    plan.textContent = "…";
    try {
      const p = await get(`campaigns/${encodeURIComponent(chosen("campaign"))}/plan`);
      plan.textContent = `${p.points} points, ${duration(p.duration_s)} of bench time, of it ${duration(p.heating_s)} warming; ${number(p.energy_j / 3.6e6, 2)} kWh.`;
    } catch (error) { plan.textContent = sentence(error); }
  };
  sheet("Start a campaign", body, [[state.runs.some(r => r.state === "running") ? "Put it into the queue" : "Start", async () => {
    const busy = Boolean(running()), behind = state.held; // the answer may come after the run's begin
    const others = state.runs.some(run => run.state === "queued");
    const answer = await post("runs", held({ name: me.name, campaign: chosen("campaign"), real_time: chosen("pace") === "clock", ...(chosen("twin") ? { twin: chosen("twin"), twin_pause: pauses.checked } : {}) }));
    toast(answer.state === "queued" ? behind && busy ? "It waits: the queue is held" : behind && others ? "It begins alone; the other runs stay held" : "It begins as soon as the bench is free" : "It waits for whoever holds the controls");
    // whoever started it wants to see it
    if (answer.state === "queued" && !busy) document.dispatchEvent(new CustomEvent("view", { detail: "now" }));
  }]]);
  for (const input of document.querySelectorAll("#sheet-body input[name=campaign]")) input.addEventListener("change", look);
  look();
}

const QUICK = ["All well at the bench.", "Unusual noise.", "Oil looked at.", "Somebody was at the bench.", "Door or window opened."];

export function note() {
  const field = make("input", { type: "text", maxlength: 500 }), run = current();
  const say = text => post("run/note", held({ run, text }));
  sheet("A remark for the recording", [
    ...QUICK.map(text => make("button", { type: "button", on: { click: () => { field.value = text; } }, style: "margin:.25rem" }, text)),
    make("label", { class: "field" }, "Remark", field),
  ], [["Write it down", () => say(field.value.trim())]]);
}

export function point(act, one) {
  const run = current();
  withControls(() => sheet(`${act === "skip" ? "Skip" : "Repeat"} point ${one.number}?`, [make("p", { class: "big" }, one.label),
    make("p", {}, act === "skip" ? "If it runs, the bench is brought to rest and goes on with the next point. The campaign can measure it later." : "It is measured once more after the one that runs. Every take is kept.")],
  [[act === "skip" ? "Skip it" : "Repeat it", () => post(`run/${act}`, held({ run, point: one.identity }))]]));
}

export function abort() {
  const run = current();
  sheet("End this run?", [make("p", { class: "big" }, running()?.title ?? ""), make("p", {}, "The bench is brought to rest and the recording is finished. What is missing can be measured later: the campaign goes on where it stopped.")],
    [["End the run", () => post("run/abort", held({ run })), "hard"]]);
}

export function again(run) {
  withControls(() => sheet("Go on where it stopped?", [make("p", { class: "big" }, run.title), make("p", {}, "Points that are done are not repeated. The drives get torque again.")],
  [["Go on", () => post(`runs/${run.id}/again`, held({}))]]));
}

export function reset() {
  const run = last();
  sheet("Reset the bench?", [make("p", {}, state.latch?.text ? `It was stopped: ${state.latch.text}.` : "No stop is on record."),
    make("p", {}, "Do it when the reason is gone. The drives lose their faults and the bench looks whether all is well; no torque is given.")],
  [["Reset", () => post("reset", held({ run }))]]);
}

export const simple = (path, more = {}) => withControls(() => doIt(() => post(path, held(more))));
const ofRun = path => { const run = current(); return simple(path, { run }); };
export const acknowledge = alarm => simple(`alarms/${alarm.number}/acknowledge`);

export function buttons() {
  const now = [...state.points.values()].find(one => ["running", "heating"].includes(one.state));
  const done = [...state.points.values()].filter(one => ["done", "failed"].includes(one.state)).pop();
  const ended = unfinished().pop();
  const list = [
    ["start", running() ? "Queue a campaign" : "Start a campaign", () => withControls(() => start()), may("start"), "main"],
    ["pause", "Pause after this point", () => ofRun("run/pause"), may("pause")],
    ["go_on", state.status.phase === "paused" ? "Go on" : "Do not pause", () => ofRun("run/go-on"), may("go_on"), "main"],
    ["skip", "Skip this point", () => point("skip", now), may("skip") && Boolean(now)],
    ["repeat", "Repeat the last point", () => point("repeat", done), may("repeat") && Boolean(done)],
    ["note", "Remark", () => withControls(note), may("note")],
    ["abort", "End the run", () => withControls(abort), may("abort"), "hard"],
    ["again", "Go on where it stopped", () => again(ended), may("again") && Boolean(ended), "main"],
    ["jog", "Move by hand", () => withControls(jog), may("jog")],
    ["tare", "Tare", () => withControls(tare), may("tare")],
    ["reset", "Reset the bench", () => withControls(reset), may("reset"), state.latch?.due === "reset" ? "main" : ""],
  ];
  // What cannot be done is left out where it would never make sense now, and greyed where it soon may.
  const shown = running() ? list.filter(([act]) => !["again", "reset"].includes(act) && (act !== "go_on" || may("go_on")) && (act !== "pause" || !may("go_on"))) : list.filter(([act]) => act === "start" || ["jog", "tare"].includes(act) || (act === "reset" && (may("reset") || state.latch?.due)) || (act === "again" && ended));
  return shown.map(([act, label, click, possible, kind = ""]) => make("button", { type: "button", "data-act": act, class: kind, disabled: !possible, on: { click } }, label));
}

export { newId };
