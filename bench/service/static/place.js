// The view "Storage & book": room on the disk, backup, appearance, the record book.

import { get } from "./api.js";
import { doIt } from "./acts.js";
import { redraw } from "./charts.js";
import { $, bytes, choice, make, moment, number, pill, toast } from "./text.js";

export function theme(value = localStorage.getItem("theme") || "auto") {
  localStorage.setItem("theme", value);
  const dark = value === "dark" || (value === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
  document.documentElement.classList.toggle("dark", dark);
  redraw();
}

export function open() {
  choice($("themes"), [["auto", "as the computer"], ["light", "light"], ["dark", "dark"]], localStorage.getItem("theme") || "auto", theme);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => theme());
}

export async function show() {
  const [storage, book] = await Promise.all([doIt(() => get("storage"), ""), doIt(() => get("book"), "")]);
  $("toast").hidden = true;
  if (storage) {
    const copy = make("button", { type: "button", on: { click: async () => { try { await navigator.clipboard.writeText(storage.backup); toast("copied"); } catch { toast("This browser does not allow copying; select the text."); } } } }, "Copy the command");
    $("storage").replaceChildren(make("dl", {},
      make("dt", {}, "Recordings lie in"), make("dd", {}, make("code", {}, storage.folder)),
      make("dt", {}, "Free"), make("dd", {}, `${bytes(storage.free_bytes)} of ${bytes(storage.total_bytes)} `, pill(storage.enough ? "done" : "failed", storage.enough ? "enough" : "nearly full")),
      make("dt", {}, "Room for about"), make("dd", {}, `${number(storage.hours, 0)} hours of recording (a run keeps ${bytes(storage.minimum_free_bytes)} free)`),
      make("dt", {}, "Back up with"), make("dd", {}, make("code", {}, storage.backup))), make("p", { class: "quiet" }, storage.backup_note), copy);
  }
  if (book) $("book").replaceChildren(make("table", {}, make("tbody", {}, ...book.map(entry => make("tr", {},
    make("td", {}, moment(entry.at)), make("td", {}, pill(entry.act === "alarm" || entry.act === "stop" ? "failed" : "", entry.act.replaceAll("_", " "))), make("td", {}, entry.by), make("td", {}, entry.text))))));
}
