// The search in the view "Recordings": every field narrows down; without any, the campaign folders as they lie there.

import { get } from "./api.js";
import { sentence } from "./acts.js";
import { $, bytes, DEGREES, duration, make, moment, pill, setpoint } from "./text.js";

const AFTER_MS = 300;
const TEXTS = ["words", "since", "until", "gearbox", "person", "bench", "tag", "kind", "result"];
const NUMBERS = { load_torque: 1, velocity: 1 / DEGREES, temperature: 1 };
let timer, asked = 0, openFolder, openRecording, isOpen;

export const head = (...names) => make("thead", {}, make("tr", {}, ...names.map(name => make(name ? "th" : "td", {}, name))));
export const opened = (element, act) => {
  element.tabIndex = 0;
  element.setAttribute("data-open", "");
  element.addEventListener("click", act);
  element.addEventListener("keydown", event => { if (event.key === "Enter") act(); });
  return element;
};
export const RESULT = { passed: "done", "not passed": "failed", "cut short": "skipped", "not judged": "", "no use": "failed" };

// `shown` says of a folder and a file whether that recording waits for another one to lie over it.
export function open(folder, recording, shown) {
  isOpen = shown;
  openFolder = folder;
  openRecording = recording;
  for (const input of document.querySelectorAll("#search input, #search select")) input.addEventListener("input", () => { clearTimeout(timer); timer = setTimeout(find, AFTER_MS); });
  $("folders-reload").addEventListener("click", find);
  get("archive/words").then(words => {
    for (const [id, list] of [["q-kind", words.kinds], ["q-result", words.results]]) $(id).replaceChildren(make("option", { value: "" }, "any"), ...list.map(one => make("option", { value: one }, one.replaceAll("_", " "))));
  }).catch(error => { $("found-problem").textContent = sentence(error); });
}

function query() {
  const asks = new URLSearchParams();
  for (const name of TEXTS) if ($(`q-${name}`).value.trim()) asks.set(name, $(`q-${name}`).value.trim());
  for (const [name, factor] of Object.entries(NUMBERS)) {
    const text = $(`q-${name}`).value.trim().replace("−", "-").replace(",", ".");
    if (!text) continue;
    if (!Number.isFinite(Number(text))) throw new Error(`“${text}” is no number`);
    asks.set(name, Number(text) * factor);
  }
  return asks;
}

export async function find() {
  const mine = ++asked;
  $("found-problem").textContent = "";
  try {
    const asks = query(), wanted = [...asks].length > 0, aside = $("q-archived").checked;
    if (aside) asks.set("archived", "true");
    const answer = await get(wanted ? `archive?${asks}` : "folders");
    if (mine !== asked) return;
    if (wanted) found(answer); else folders(answer.filter(one => aside || !one.archived), answer.some(one => one.archived) && !aside);
  } catch (error) {
    if (mine === asked) $("found-problem").textContent = error.message || sentence(error);
  }
}

function folders(list, hidden) {
  $("found").replaceChildren();
  $("found-text").textContent = list.length ? `${list.length} campaign${list.length === 1 ? "" : "s"}${hidden ? "; others were put aside" : ""}` : "There are no recordings yet.";
  $("folders").replaceChildren(...(list.length ? [make("table", {}, head("Folder", "Recordings", "Points done", "Size", "Last change"), make("tbody", {}, ...list.map(one =>
    opened(make("tr", {}, make("td", {}, make("b", {}, one.name)), make("td", { "data-unit": "recordings" }, String(one.recordings)),
      make("td", { "data-unit": "points done" }, one.done + one.failed + one.cut_short === 0 ? "–" : `${one.done}${one.failed ? `, ${one.failed} not passed` : ""}${one.cut_short ? `, ${one.cut_short} cut short` : ""}`),
      make("td", {}, bytes(one.bytes)), make("td", {}, moment(one.changed_at * 1000))), () => openFolder(one.name)))))] : []));
}

function found(answer) {
  const { total, recordings: list, folders: places } = answer;
  $("found-text").textContent = total ? `${total} recording${total === 1 ? "" : "s"} in ${places.length} campaign${places.length === 1 ? "" : "s"}${list.length < total ? `; the newest ${list.length} are shown` : ""}` : "Nothing is like that.";
  $("folders").replaceChildren(...(places.length ? [make("table", {}, head("Campaign", "Found", "Gearbox", "Person", "Begun"), make("tbody", {}, ...places.map(one =>
    opened(make("tr", {}, make("td", {}, make("b", {}, one.name)), make("td", { "data-unit": "found" }, String(one.recordings)), make("td", {}, one.gearbox || "–"), make("td", {}, one.person || "–"),
      make("td", {}, one.first_s ? moment(one.first_s * 1000) : "–")), () => openFolder(one.name)))))] : []));
  $("found").replaceChildren(...(list.length ? [make("h2", {}, "Recordings"), make("table", {}, head("Recording", "Set point", "Kept", "Length", "Gearbox", "Begun", "Tags"), make("tbody", {}, ...list.map(one =>
    opened(make("tr", {}, make("td", {}, make("b", {}, one.recording_id), make("small", { class: "quiet" }, ` ${one.folder}`), isOpen(one.folder, one.file) ? make("small", { class: "this-one" }, " this is the one that is open") : null), make("td", {}, setpoint(one)), make("td", {}, pill(RESULT[one.result], one.result)),
      make("td", {}, duration(one.duration_s)), make("td", {}, one.gearbox || "–"), make("td", {}, one.started_s ? moment(one.started_s * 1000) : "–"), make("td", {}, one.tags.join(", "))),
    () => (one.result === "no use" ? openFolder(one.folder) : openRecording(one.folder, { ...one, id: one.recording_id }))))))] : []));
}

