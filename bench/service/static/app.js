// The page: puts the views together and follows the service.

import * as acts from "./acts.js";
import * as analysis from "./analysis.js";
import { listen, post, showToken } from "./api.js";
import * as campaign from "./campaign.js";
import * as keys from "./keys.js";
import * as now from "./now.js";
import * as place from "./place.js";
import * as plan from "./plan.js";
import * as recordings from "./recordings.js";
import { me, running, state } from "./state.js";
import * as trend from "./trend.js";
import * as stop from "./stop.js";
import { $, make, moment, toast } from "./text.js";

const VIEWS = { now: now.spectrum, campaign: () => { campaign.queue(); campaign.points(); }, plan: plan.show, recordings: recordings.folders, analysis: analysis.analyses, trend: trend.show, place: place.show };

function view(name) {
  for (const tab of $("tabs").children) tab.setAttribute("aria-selected", tab.dataset.view === name);
  for (const id of Object.keys(VIEWS)) $(id).hidden = id !== name;
  // each page begins at its own top
  if (sessionStorage.getItem("view") !== name) scrollTo({ top: 0, behavior: "instant" });
  sessionStorage.setItem("view", name);
  VIEWS[name]();
}

function header() {
  $("bench").textContent = state.about.bench;
  $("bench").title = state.about.title;
  emulated();
  document.title = `${state.alarms.length ? "⚠ " : ""}${state.about.bench || "Gearbox bench"}`;
  const { holder } = state;
  $("holder").replaceChildren(...(me.holds ? ["You hold the controls", make("small", {}, holder.name)]
    : holder ? [holder.name, make("small", {}, holder.offered_to ? `offers the controls to ${holder.offered_to}` : holder.away ? "holds the controls, is away" : "holds the controls")]
      : ["Take the controls", make("small", {}, "nobody holds them")]));
}

// Nobody may take the emulated bench for a real one, nor its hours for hours.
function emulated() {
  const run = running();
  $("emulated").hidden = !state.about.emulated;
  $("emulated").textContent = `EMULATED · ${run && !run.real_time ? "fast" : "real time"}`;
  document.body.classList.toggle("is-emulated", state.about.emulated);
}

// Controls that were taken, or that ended with the service, are not lost without a word.
function lost() {
  if (!me.secret || me.holds) return;
  me.letGo();
  toast(state.holder ? `${state.holder.name} has taken the controls${state.holder.name === me.name ? " in another browser" : ""}` : "You no longer hold the controls");
}

let alarmsShown = "";
function alarms() {
  const key = JSON.stringify(state.alarms);
  if (key === alarmsShown) return;
  alarmsShown = key;
  $("alarms").replaceChildren(...state.alarms.map(alarm => make("div", { class: "alarm-card" },
    make("div", {}, make("b", {}, alarm.text), make("p", {}, alarm.what_to_do), make("small", { class: "quiet" }, [moment(alarm.at), alarm.point].filter(Boolean).join(" · "))),
    make("div", { class: "acts" },
      alarm.cause === "TWIN" && alarm.folder ? make("button", { type: "button", on: { click: () => compare(alarm) } }, "Compare before and since") : null,
      alarm.clears_itself ? make("small", { class: "quiet" }, "goes when it is over")
        : make("button", { type: "button", class: "hard", on: { click: () => acts.acknowledge(alarm) } }, "Acknowledge")))));
}

// What the twin's alarm is about: the recordings before the change and those since, each identified.
async function compare(alarm) {
  const asked = { name: me.name || "somebody", kind: "compare", folder: alarm.folder, since: alarm.point };
  if (await acts.doIt(() => post("analyses", asked), "Both parts are identified; what changed comes under Analysis")) view("analysis");
}

const ON = {
  about(message) { state.about = message; header(); },
  state(message) { Object.assign(state, message); lost(); header(); alarms(); now.status(); campaign.queue(); campaign.enable(); analysis.analyses(); },
  runs(message) { state.runs = message.runs; state.held = message.held; emulated(); now.status(); campaign.queue(); analysis.analyses(); },
  plan(message) { state.plan = message; state.points = new Map(message.points.map(one => [one.identity, one])); campaign.points(); now.status(); },
  point(message) { state.points.set(message.identity, message); campaign.point(message); now.status(); },
  status(message) { state.status = message; now.status(); },
  live(message) { now.live(message); },
  condition(message) { now.condition(message); },
  unread(message) { now.condition(message); },
  spectrum(message) { state.spectrum = message; if (!$("now").hidden) now.spectrum(); },
  analyses(message) { state.analyses = message.analyses; analysis.analyses(); },
  clear() { state.plan = null; state.points = new Map(); state.spectrum = null; now.clear(); now.spectrum(); campaign.points(); },
  back() { toast("The service answers again."); now.load(); },
};

function gone(since) {
  $("gone").hidden = since === null;
  if (since !== null) $("gone").textContent = `The service has not answered since ${moment(since)}. What you see is old. A run that was going on goes on without it. If anything is wrong at the bench, use the emergency stop.`;
  state.gone = since !== null;
  now.status();
  stop.show();
}

// Without the token nothing is shown: it is asked for, and a cookie stands for it afterwards.
function askToken() {
  if ($("sheet").open) return;
  const token = make("input", { type: "password", id: "token", autocomplete: "current-password", maxlength: 200 });
  acts.sheet("This page needs the token of the service", [make("p", {}, "It is in the file given with --token-file, and in the address that the service printed."), make("label", { class: "field" }, "Token", token)],
    [["Go on", async () => { await post("session", { token: token.value.trim() }, { id: false }); location.reload(); }]]);
}

async function main() {
  place.theme();
  // sheets and what is scrolled to begin below the header, however high it is on this screen
  // on a phone they end above the pages at the lower edge
  new ResizeObserver(() => document.documentElement.style.setProperty("--nav", `${document.querySelector("nav").offsetHeight}px`)).observe(document.querySelector("nav"));
  new ResizeObserver(() => document.documentElement.style.setProperty("--header", `${document.querySelector("header").offsetHeight}px`)).observe(document.querySelector("header"));
  for (const part of [now, campaign, plan, recordings, analysis, trend, place]) part.open();
  for (const tab of $("tabs").children) {
    tab.id = `tab-${tab.dataset.view}`;
    tab.setAttribute("aria-controls", tab.dataset.view);
    $(tab.dataset.view).setAttribute("role", "tabpanel");
    $(tab.dataset.view).setAttribute("aria-labelledby", tab.id);
    tab.addEventListener("click", () => view(tab.dataset.view));
  }
  // pointerdown: a gloved finger that slides off the button has pressed it all the same
  $("stop").addEventListener("pointerdown", stop.stop);
  $("stop").addEventListener("keydown", event => { if (event.key === "Enter" || event.key === " ") stop.stop(); });
  $("holder").addEventListener("click", () => acts.controls());
  document.addEventListener("controls", header);
  document.addEventListener("view", event => view(event.detail));
  document.addEventListener("token", askToken);
  keys.open(stop.stop);
  setInterval(() => { $("clock").textContent = new Date().toLocaleTimeString([], { hour12: false }); }, 500);
  view(sessionStorage.getItem("view") || "now");
  try { await showToken(); } catch (error) { toast(acts.sentence(error)); }
  listen((type, message) => { ON[type]?.(message); if (["state", "runs", "status"].includes(type)) stop.heard(); }, gone);
  await now.load().catch(error => toast(acts.sentence(error)));
}

main();
