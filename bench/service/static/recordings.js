// The view "Recordings": folders, their recordings, plots of one; identification and mismatch reports are started here.

import { get, post } from "./api.js";
import { doIt, sheet } from "./acts.js";
import { bandPlot, curvePlot, showSpectrum, spectrumPlot } from "./charts.js";
import { me, state } from "./state.js";
import { $, bytes, duration, make, moment, number, pill, setpoint } from "./text.js";

let shown = [];
const LABELS = { motor_velocity: "Speed from the motor, load side", load_velocity: "Speed, load side", load_torque: "Load torque (sensor)", load_motor_torque: "Load motor torque", motor_torque: "Motor torque", temperature: "Lubricant" };

export function open() { $("folders-reload").addEventListener("click", folders); }

const opened = (element, act) => {
  element.tabIndex = 0;
  element.setAttribute("data-open", "");
  element.addEventListener("click", act);
  element.addEventListener("keydown", event => { if (event.key === "Enter") act(); });
  return element;
};
const head = (...names) => make("thead", {}, make("tr", {}, ...names.map(name => make("th", {}, name))));

export async function folders() {
  const list = await doIt(() => get("folders"), "");
  if (!list) return;
  $("toast").hidden = true;
  $("folders").replaceChildren(list.length ? make("table", {}, head("Folder", "Recordings", "Points done", "Size", "Last change"), make("tbody", {}, ...list.map(one =>
    opened(make("tr", {}, make("td", {}, make("b", {}, one.name)), make("td", { "data-unit": "recordings" }, String(one.recordings)),
      make("td", { "data-unit": "points done" }, one.done + one.failed === 0 ? "–" : `${one.done}${one.failed ? `, ${one.failed} not passed` : ""}`),
      make("td", {}, bytes(one.bytes)), make("td", {}, moment(one.changed_at * 1000))), () => folder(one.name)))))
    : make("p", { class: "quiet" }, "There are no recordings yet."));
}

export async function folder(name) {
  const list = await doIt(() => get(`folders/${encodeURIComponent(name)}`), "");
  if (!list) return;
  $("toast").hidden = true;
  $("folder-card").hidden = false;
  $("folder-title").textContent = name;
  $("folder-acts").replaceChildren(
    make("button", { type: "button", class: "main", on: { click: () => analyse("identify", name) } }, "Identify"),
    make("button", { type: "button", class: "main", on: { click: () => analyse("mismatch", name) } }, "What does the simulation leave out?"));
  $("folder-list").replaceChildren(make("table", {}, head("Recording", "Set point", "Kept", "Length", "Begun"), make("tbody", {}, ...list.map(one => one.why
    ? make("tr", {}, make("td", {}, one.file), make("td", { colspan: 4 }, pill("failed", "no use"), ` ${one.why.replace(/^.*?: /, "")}`))
    : opened(make("tr", {}, make("td", {}, make("b", {}, one.id)), make("td", {}, setpoint(one)),
      make("td", {}, one.accepted ? pill("done", "passed") : !one.complete ? pill("skipped", "cut short") : one.accepted === null ? pill("", "not judged") : pill("failed", "not passed")),
      make("td", {}, duration(one.duration_s)), make("td", {}, moment(one.started_at))), () => recording(name, one))))));
  $("folder-card").scrollIntoView({ behavior: "smooth", block: "start" });
}

async function recording(folderName, one) {
  const path = `folders/${encodeURIComponent(folderName)}/${encodeURIComponent(one.file)}`;
  const data = await doIt(() => get(`${path}/plot`), "");
  if (!data) return;
  $("toast").hidden = true;
  for (const plot of shown) plot.drop();
  shown = [];
  $("recording-card").hidden = false;
  $("recording-title").textContent = `${one.id}: ${setpoint(one)}`;
  $("recording-text").textContent = [...data.events.map(e => `${number(e.time, 1)} s ${e.level}: ${e.text}`), ...data.problems].join(" · ") || "No events.";
  $("recording-plots").replaceChildren();
  revolution(path);
  for (const [name, channel] of Object.entries(data.channels)) {
    const place = make("div", { class: "plot" });
    $("recording-plots").append(place);
    const plot = bandPlot(place, { title: `${LABELS[name] ?? name}, ${channel.unit} over seconds`, set: null, actual: "mean", least: 1e-3, clockTime: false, height: 170 });
    plot.show([data.time, data.time.map(() => null), channel.low, channel.high, channel.mean]);
    shown.push(plot);
  }
  $("recording-card").scrollIntoView({ behavior: "smooth", block: "start" });
}

async function revolution(path) {
  let message;
  try { message = await get(`${path}/revolution`); } catch (error) {
    $("recording-plots").prepend(make("p", { class: "quiet" }, error.message));
    return;
  }
  const places = [make("div", { class: "plot tall" }), make("div", { class: "plot" })];
  $("recording-plots").prepend(make("h2", {}, `Transmission error over a revolution: ${number(message.rms * 1e6, 1)} µrad RMS`), ...places);
  const spectrum = spectrumPlot(places[0]), curve = curvePlot(places[1]);
  showSpectrum(spectrum, curve, message);
  shown.push(spectrum, curve);
}

function analyse(kind, name) {
  const models = state.analyses.filter(one => one.has_model && one.state === "done");
  const radios = [["", "The nominal simulation, calibrated on a part of the recordings"], ...models.map(one => [one.id, `${one.kind === "identify" ? "The model identified from" : "The better simulation of the report on"} ${one.folder}, ${moment(one.asked_at)}`])];
  const who = make("input", { type: "text", maxlength: 40, value: me.name });
  const body = [
    make("p", {}, kind === "identify" ? "Transmission error, friction, heat balance and load side are identified and validated; a report and a model are written." : "Where the simulation and these recordings differ, what physics was left out, and how much better it fits with it."),
    ...(kind === "mismatch" ? [make("h2", {}, "Compare with"), ...radios.map(([value, label], i) => make("label", { class: "option" }, make("input", { type: "radio", name: "model", value, checked: i === 0 }), make("span", {}, label)))] : []),
    ...(me.name ? [] : [make("label", { class: "field" }, "Your name, for the record", who)]),
  ];
  sheet(kind === "identify" ? `Identify ${name}` : `What does the simulation leave out? (${name})`, body, [["Start", async () => {
    me.name = who.value.trim() || me.name;
    const model = document.querySelector("#sheet-body input[name=model]:checked")?.value || null;
    await post("analyses", { name: me.name, kind, folder: name, ...(model ? { model } : {}) });
    document.querySelector("#tabs [data-view=analysis]").click();
  }]]);
}
