// The view "Recordings": a folder and its recordings, one of them as an instrument: channels, zoom, a second one over it.

import { get, post } from "./api.js";
import { doIt, sheet } from "./acts.js";
import { changes, lookForLike } from "./changes.js";
import { bandPlot, curvePlot, modelText, showSpectrum, spectrumPlot } from "./charts.js";
import * as find from "./find.js";
import { savePicture, saveValues } from "./marks.js";
import { me, state } from "./state.js";
import { $, duration, make, moment, number, pill, setpoint } from "./text.js";

const { head, opened } = find;
const LABELS = { motor_velocity: "Speed from the motor, load side", load_velocity: "Speed, load side", load_torque: "Load torque (sensor)", load_motor_torque: "Load motor torque", motor_torque: "Motor torque", temperature: "Lubricant" };
const MOST_MARKS = 40;
// What is open: { folder, one, path, data }; `under` was opened before and stays below it.
let main = null, under = null, plots = {}, turned = [], asked = 0;
const hidden = new Set();

export function open() { find.open(folder, recording, (place, file) => under === main && under?.folder === place && under?.one.file === file); }
export const folders = find.find;
const pathOf = (name, file) => `folders/${encodeURIComponent(name)}/${encodeURIComponent(file)}`;

export async function folder(name) {
  const list = await doIt(() => get(`folders/${encodeURIComponent(name)}`), "");
  if (!list) return;
  $("toast").hidden = true;
  $("folder-card").hidden = false;
  $("folder-title").textContent = name;
  $("folder-acts").replaceChildren(
    make("button", { type: "button", class: "main", on: { click: () => analyse("identify", name) } }, "Identify"),
    make("button", { type: "button", class: "main", on: { click: () => analyse("mismatch", name) } }, "What does the simulation leave out?"),
    make("a", { class: "button", href: `/api/folders/${encodeURIComponent(name)}/download` }, "Download all"),
    ...noteButtons(name, null, () => folder(name)));
  $("folder-list").replaceChildren(make("table", {}, head("Recording", "Set point", "Kept", "Length", "Begun"), make("tbody", {}, ...list.map(one => one.why
    ? make("tr", {}, make("td", {}, one.file), make("td", { colspan: 4 }, pill("failed", "no use"), ` ${one.why.replace(/^.*?: /, "")}`))
    : opened(make("tr", {}, make("td", {}, make("b", {}, one.id)), make("td", {}, setpoint(one)),
      make("td", {}, one.accepted ? pill("done", "passed") : !one.complete ? pill("skipped", "cut short") : one.accepted === null ? pill("", "not judged") : pill("failed", "not passed")),
      make("td", {}, duration(one.duration_s)), make("td", {}, moment(one.started_at))), () => recording(name, one))))));
  $("folder-card").scrollIntoView({ behavior: "smooth", block: "start" });
}

async function recording(folderName, one) {
  const path = pathOf(folderName, one.file), data = await doIt(() => get(`${path}/plot`), "");
  if (!data) return;
  $("toast").hidden = true;
  main = { folder: folderName, one, path, data };
  if (under?.path === path) under = null;
  $("recording-card").hidden = false;
  $("recording-title").textContent = `${one.id}: ${setpoint(one)}${under ? `, over ${under.one.id} of ${under.folder}` : ""}`;
  const gaps = data.gaps ? `Cycles were lost at ${data.gaps} place${data.gaps === 1 ? "" : "s"}, drawn as gaps.` : "";
  $("recording-text").textContent = [`${folderName}, ${moment(data.started_at)}, ${duration(data.duration_s)}`, gaps, ...data.problems].filter(Boolean).join(" · ");
  $("recording-events").replaceChildren(...data.events.map(e => make("li", {}, `${number(e.time, 1)} s ${e.level}: ${e.text}`)));
  tools();
  notes();
  draw();
  $("recording-card").scrollIntoView({ behavior: "smooth", block: "start" });
}

function tools() {
  const { path, one, folder: place } = main, all = () => [...turned, ...Object.values(plots)];
  const button = (label, click) => make("button", { type: "button", on: { click } }, label);
  const link = (form, label) => make("a", { class: "button", href: `/api/${path}/download?form=${form}` }, label);
  $("recording-acts").replaceChildren(
    under ? button("Take the other away", () => { under = null; recording(place, one); })
      : button("Lay another over it", another),
    button("Picture", () => savePicture(all(), one.id, `${$("recording-title").textContent} · ${$("recording-text").textContent}`)), button("Values", () => saveValues(all(), one.id)),
    link("hdf5", "HDF5"), link("csv", "CSV"), link("mat", "MAT"), ...noteButtons(place, one.file, notes));
}

// Of the same gearbox, at the same set point: an earlier run is one of those that are found.
function another() {
  const { one, data } = main;
  under = main;
  $("toast").hidden = true;
  lookForLike(one, data.gearbox, async () => {
    await find.find();
    $("found-text").textContent = `${$("found-text").textContent} of this gearbox at this set point. Choose the one to lay over ${one.id}, or clear a field to see more.`;
    $("search").scrollIntoView({ behavior: "smooth" });
  });
}

// -- what people say of it ----------------------------------------------------------------------------------------------

function noteButtons(place, file, then) {
  const say = (kind, text = "") => post("archive/notes", { name: me.name, folder: place, ...(file ? { file } : {}), kind, text });
  const ask = (title, kind, label) => {
    const text = make("input", { type: "text", maxlength: 500 }), who = make("input", { type: "text", maxlength: 40, value: me.name });
    sheet(title, [make("label", { class: "field" }, label, text), make("label", { class: "field" }, "Your name, for the record", who)],
      [["Write it down", async () => { me.name = who.value.trim() || me.name; const answer = await say(kind, text.value.trim()); then(); return answer; }]]);
  };
  const aside = () => {
    const who = make("input", { type: "text", maxlength: 40, value: me.name });
    const act = kind => async () => { me.name = who.value.trim() || me.name; const answer = await say(kind); find.find(); return answer; };
    sheet(`Put ${file ?? place} aside?`, [make("p", {}, "It is no longer shown or found, unless what was put aside is asked for. Nothing is deleted."), make("label", { class: "field" }, "Your name, for the record", who)],
      [["Put it aside", act("archive")], ["Bring it back", act("restore"), ""]]);
  };
  const what = file ? "this recording" : place;
  return [["Comment", () => ask(`A comment on ${what}`, "comment", "Comment")], ["Tag", () => ask(`A tag for ${what}`, "tag", "Tag")], ["Put aside", aside]]
    .map(([label, click]) => make("button", { type: "button", on: { click } }, label));
}

async function notes() {
  const { folder: place, one } = main;
  try {
    const { recordings: list } = await get(`archive?${new URLSearchParams({ words: one.id, archived: true, limit: 500 })}`);
    const mine = list.find(each => each.folder === place && each.file === one.file);
    if (main.one !== one || !mine) return;
    const untag = tag => async () => { await doIt(() => post("archive/notes", { name: me.name || "somebody", folder: place, file: one.file, kind: "untag", text: tag })); notes(); };
    $("recording-notes").replaceChildren(...mine.tags.map(tag => make("button", { type: "button", class: "tag", title: "take this tag away", on: { click: untag(tag) } }, `${tag} ×`)), ...mine.comments.map(text => make("p", {}, text)));
  } catch (error) { $("recording-notes").replaceChildren(make("p", { class: "quiet" }, error.message)); }
}

// -- plots --------------------------------------------------------------------------------------------------------------

function draw() {
  for (const plot of [...Object.values(plots), ...turned]) plot.drop();
  plots = {};
  turned = [];
  const names = Object.keys(main.data.channels);
  $("channels").replaceChildren(...names.map(name => make("button", { type: "button", role: "checkbox", "aria-checked": String(!hidden.has(name)), on: { click: () => { if (!hidden.delete(name)) hidden.add(name); draw(); } } }, LABELS[name] ?? name)));
  // the revolution is worked out while the channels are drawn already: its place is kept, or they would move under the mouse
  const first = make("div", { class: "revolution" }, make("p", { class: "quiet" }, "The transmission error over a revolution is being computed."));
  $("recording-plots").replaceChildren(first);
  revolution(first);
  for (const name of names.filter(each => !hidden.has(each))) {
    const place = make("div", { class: "plot", "data-channel": name });
    $("recording-plots").append(place);
    plots[name] = bandPlot(place, { title: `${LABELS[name] ?? name}, ${main.data.channels[name].unit} over seconds`, set: null, least: 1e-3, clockTime: false, height: 170, other: under ? `mean of ${under.one.id}, ${under.folder}` : null, sync: "recording" });
    plots[name].onZoom = look;
  }
  fill(main.data, under?.data, null);
}

// What is looked into is asked for again: a stretch of a second shows its own 800 parts, not one of an hour's.
async function look(stretch) {
  const mine = ++asked, asks = stretch ? `?${new URLSearchParams({ start: Math.max(0, stretch[0]), stop: Math.max(0, stretch[1]) })}` : "";
  const [data, below] = await Promise.all([get(`${main.path}/plot${asks}`), under ? get(`${under.path}/plot${asks}`) : null]).catch(error => { $("recording-text").textContent = error.message; return [null, null]; });
  if (data && mine === asked) fill(data, below, stretch);
}

function fill(data, below, stretch) {
  const marks = data.events.slice(0, MOST_MARKS).map((event, i) => ({ time: event.time, label: String(i + 1), level: event.level }));
  for (const [name, plot] of Object.entries(plots)) {
    const { low, high, mean } = data.channels[name];
    plot.zoom = stretch;
    plot.marks = marks;
    plot.place.classList.toggle("zoomed", stretch !== null);
    plot.show(joined(data.time, [low, high, mean], below?.time ?? [], below?.channels[name]?.mean ?? []), stretch);
  }
}

// Two recordings on one axis, seconds since each began: where one has no value at a time of the other, none is drawn (undefined joins, null parts).
function joined(time, columns, otherTime, other) {
  if (!otherTime.length) return [time, time.map(() => null), ...columns, time.map(() => null)];
  const [all, mine, theirs] = [[], [], []];
  for (let i = 0, k = 0; i < time.length || k < otherTime.length;) {
    const [a, b] = [time[i] ?? Infinity, otherTime[k] ?? Infinity], at = Math.min(a, b);
    all.push(at);
    mine.push(a === at ? i++ : -1);
    theirs.push(b === at ? k++ : -1);
  }
  const pick = (column, index) => index.map(i => i < 0 ? undefined : column[i] ?? null);
  return [all, all.map(() => null), ...columns.map(column => pick(column, mine)), pick(other, theirs)];
}

async function revolution(first) {
  let message;
  try { message = await get(`${main.path}/revolution`); } catch (error) {
    first.replaceChildren(make("p", { class: "quiet" }, error.message));
    first.classList.add("without");
    return;
  }
  if (!first.isConnected) return;
  const second = under ? await get(`${under.path}/revolution`).catch(() => null) : null;
  if (!first.isConnected) return;
  const places = [make("div", { class: "plot tall" }), make("div", { class: "plot" })], model = message.model && !second;
  first.replaceChildren(make("h2", {}, `Transmission error over a revolution: ${number(message.rms * 1e6, 1)} µrad RMS${second ? `, below it ${number(second.rms * 1e6, 1)} µrad RMS of ${under.one.id}, ${under.folder}` : ""}`),
    make("p", { class: "quiet" }, second ? "Circles and dashes: the other recording." : message.model || message.model_why ? modelText(message) : ""), ...places);
  const below = second ? "the other" : "model", spectrum = spectrumPlot(places[0], 330, below), curve = curvePlot(places[1], 210, below, model && Boolean(message.model_band));
  turned = [spectrum, curve];
  if (second) first.prepend(changes({ ...main, turn: message }, { ...under, turn: second }));
  showSpectrum(spectrum, curve, second ? { ...message, model: second.amplitude, model_curve: second.curve } : message);
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
