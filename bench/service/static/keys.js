// The keyboard: one key an act, none while something is written; a list of them all.

import { sheet } from "./acts.js";
import { $, make } from "./text.js";

const press = selector => () => document.querySelector(selector)?.click();
const tabs = () => [...$("tabs").children];

// Key, what it does, and the act; Shift+S is STOP for everybody, as the button is.
export const keys = stop => [
  ["Shift+S", "STOP: bring the bench to rest", stop],
  ...tabs().map((tab, i) => [String(i + 1), `the page “${tab.firstChild.textContent}”`, () => tab.click()]),
  ["n", "start a campaign", press("#acts [data-act=start]")],
  ["p", "pause after this point, or take that back", press("#acts [data-act=pause]:enabled, #acts [data-act=go_on]:enabled")],
  ["r", "a remark for the recording", press("#acts [data-act=note]:enabled")],
  ["c", "the controls", press("#holder")],
  ["/", "find recordings", () => { document.querySelector("[data-view=recordings]").click(); $("q-words").focus(); }],
  ["Escape", "close what is open", () => { if ($("sheet").open) $("sheet").close(); }],
  ["?", "this list", list],
];

let known = [];
function list() {
  sheet("Keys", [make("table", {}, make("tbody", {}, ...known.map(([key, what]) => make("tr", {}, make("td", {}, make("kbd", {}, key)), make("td", {}, what)))))], []);
}

const writes = element => element.matches?.("input:not([type=radio]):not([type=checkbox]), select, textarea");

export function open(stop) {
  known = keys(stop);
  $("keys").addEventListener("click", list);
  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat) return;
    if (writes(event.target) && event.key !== "Escape") return;
    const name = event.key === "S" && event.shiftKey ? "Shift+S" : event.key;
    const found = known.find(([key]) => key === name);
    if (!found) return;
    event.preventDefault();
    found[2]();
  });
}
