// The view "Storage & book": room on the disk, backup, appearance, the record book.

import { get, post } from "./api.js";
import { doIt, sheet } from "./acts.js";
import { me } from "./state.js";
import { redraw } from "./charts.js";
import { $, bytes, choice, make, moment, number, pill, toast } from "./text.js";

let timer, asked = 0;
const ACTS = [["", "everything"], ...["alarm", "stop", "run", "remark", "note", "controls", "by_hand", "tare", "analyse", "reset", "notice", "service"].map(one => [one, one.replaceAll("_", " ")])];

export function theme(value = localStorage.getItem("theme") || "auto") {
  localStorage.setItem("theme", value);
  const dark = value === "dark" || (value === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
  document.documentElement.classList.toggle("dark", dark);
  redraw();
}

export function open() {
  choice($("themes"), [["auto", "as the computer"], ["light", "light"], ["dark", "dark"]], localStorage.getItem("theme") || "auto", theme);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => theme());
  $("book-act").replaceChildren(...ACTS.map(([value, label]) => make("option", { value }, label)));
  for (const id of ["book-words", "book-act"]) $(id).addEventListener("input", () => { clearTimeout(timer); timer = setTimeout(book, 300); });
  $("book-csv").addEventListener("click", save);
  $("book-remark").addEventListener("click", remark);
}

export async function show() {
  const [storage] = await Promise.all([doIt(() => get("storage"), ""), book()]);
  $("toast").hidden = true;
  if (storage) {
    const copy = make("button", { type: "button", on: { click: async () => { try { await navigator.clipboard.writeText(storage.backup); toast("copied"); } catch { toast("This browser does not allow copying; select the text."); } } } }, "Copy the command");
    $("storage").replaceChildren(make("dl", {},
      make("dt", {}, "Recordings lie in"), make("dd", {}, make("code", {}, storage.folder)),
      make("dt", {}, "Free"), make("dd", {}, `${bytes(storage.free_bytes)} of ${bytes(storage.total_bytes)} `, pill(storage.enough ? "done" : "failed", storage.enough ? "enough" : "nearly full")),
      make("dt", {}, "Room for about"), make("dd", {}, `${number(storage.hours, 0)} hours of recording (a run keeps ${bytes(storage.minimum_free_bytes)} free)`),
      make("dt", {}, "Back up with"), make("dd", {}, make("code", {}, storage.backup))), make("p", { class: "quiet" }, storage.backup_note), copy);
  }
}

const query = limit => new URLSearchParams({ words: $("book-words").value.trim(), act: $("book-act").value, limit });
async function book() {
  const mine = ++asked, found = await doIt(() => get(`book?${query(200)}`), "");
  if (!found || mine !== asked) return;
  $("book").replaceChildren(found.length ? make("table", {}, make("tbody", {}, ...found.map(entry => make("tr", {},
    make("td", {}, moment(entry.at)), make("td", {}, pill(entry.act === "alarm" || entry.act === "stop" ? "failed" : "", entry.act.replaceAll("_", " "))), make("td", {}, entry.by), make("td", {}, entry.text))))) : make("p", { class: "quiet" }, "There is no such entry in the book."));
  $("toast").hidden = true;
}

async function save() {
  const found = await doIt(() => get(`book?${query(100000)}`), "");
  if (!found) return;
  const cell = text => `"${String(text ?? "").replaceAll('"', '""')}"`;
  const text = [["at", "act", "by", "text", "run"], ...found.map(one => [one.at, one.act, one.by, one.text, one.run])].map(row => row.map(cell).join(",")).join("\n");
  make("a", { href: URL.createObjectURL(new Blob([`${text}\n`], { type: "text/csv" })), download: "record-book.csv" }).click();
  toast(`${found.length} entries saved`);
}

function remark() {
  const text = make("input", { type: "text", maxlength: 500 }), name = make("input", { type: "text", maxlength: 40, value: me.name, autocomplete: "name" });
  sheet("A remark for the record book", [make("label", { class: "field" }, "Remark", text), make("label", { class: "field" }, "Your name, for the record", name)],
    [["Write it down", async () => { me.name = name.value.trim() || me.name; const answer = await post("book", { name: me.name, text: text.value.trim() }); await book(); return answer; }]]);
}
