// The view "Plan": a campaign as a form made of the schema the service gives, planned while it is written, saved, started.

import * as acts from "./acts.js";
import { get, post, Refused } from "./api.js";
import { me, state } from "./state.js";
import { $, DEGREES, duration, make, number, pill } from "./text.js";

const AFTER_MS = 350;
// What a number without a unit means in this form; the file has the unit always.
const UNITS = { torque: "N*m", speed: "deg/s", temperature: "degC", angle: "deg", time: "s" };
const VALUES = { load_torques: "torque", velocities: "speed", temperatures: "temperature" };
const LABELS = { load_torques: "Load torques", velocities: "Speeds, load side", temperatures: "Lubricant temperatures" };
let schema = null, table = null, origin = null, timer, asked = 0;

const fresh = () => ({ format: "bench-campaign", format_version: "1.0", name: "my-campaign", title: "My campaign",
  stages: [{ name: "stage 1", order: "temperature", points: [{ sequence: "constant_velocity", load_torques: ["0 N*m"], velocities: ["10 deg/s", "-10 deg/s"], temperatures: ["as found"] }] }] });

export function open() {
  $("plan-new").addEventListener("click", () => edit(fresh(), null));
  $("plan-compare").addEventListener("click", compare);
  $("plan-save").addEventListener("click", save);
  // beside somebody who holds the controls it is proposed; where nobody does they are taken first
  $("plan-start").addEventListener("click", () => { const begin = () => acts.start(origin); return state.holder && !me.holds ? begin() : acts.withControls(begin); });
}

export async function show() {
  try {
    schema ??= await get("campaign-schema");
    const list = await get("campaigns");
    $("plan-list").replaceChildren(make("table", {}, make("tbody", {}, ...list.map(one => make("tr", {},
      make("td", {}, make("b", {}, one.name), make("small", { class: "quiet" }, ` ${one.problem ?? one.title}`)), make("td", {}, one.problem ? pill("failed", "wrong") : one.laboratory ? "laboratory" : "shipped"),
      make("td", {}, one.name.endsWith(".py") ? make("small", { class: "quiet" }, "a program: edit its file") : make("div", { class: "acts" },
        ...(one.laboratory ? [make("button", { type: "button", on: { click: () => load(one.name, true) } }, "Edit")] : []),
        make("button", { type: "button", on: { click: () => load(one.name, false) } }, "Copy"))))))));
    if (!table) edit(fresh(), null);
  } catch (error) { $("plan-problem").textContent = acts.sentence(error); }
}

// Two campaigns on this bench: what each takes, and the points only one of them has.
async function compare() {
  const list = (await acts.doIt(() => get("campaigns"), "") ?? []).filter(one => !one.problem);
  $("toast").hidden = true;
  const select = (label, i) => make("label", { class: "field" }, label, make("select", { class: "compared" }, ...list.map((one, k) => make("option", { value: one.name, selected: k === Math.min(i, list.length - 1) }, one.name))));
  const place = make("div", { id: "compared", role: "status" });
  const look = async () => {
    const names = [...document.querySelectorAll("select.compared")].map(one => one.value);
    place.textContent = "plans …";
    try { place.replaceChildren(...compared(names, await Promise.all(names.map(name => get(`campaigns/${encodeURIComponent(name)}/plan`))))); } catch (error) { place.textContent = acts.sentence(error); }
  };
  acts.sheet("Compare two campaigns", [select("One", 0), select("The other", 1), place], []);
  for (const one of document.querySelectorAll("select.compared")) one.addEventListener("change", look);
  look();
}

function compared(names, plans) {
  const key = one => [one.sequence.replaceAll("_", " "), `${number(one.load_torque_nm, 0)} N·m`, `${number(one.velocity_rad_s * DEGREES, 1)} °/s`, one.temperature_degc === null ? "as found" : `${number(one.temperature_degc, 1)} °C`].join(", ");
  const counts = plans.map(plan => { const found = new Map(); for (const one of plan.tasks.filter(task => task.number)) found.set(key(one), (found.get(key(one)) ?? 0) + 1); return found; });
  const rows = [...new Set(counts.flatMap(found => [...found.keys()]))].map(name => [name, ...counts.map(found => found.get(name) ?? 0)]);
  const differ = rows.filter(([, a, b]) => a !== b);
  const total = (label, of) => make("tr", {}, make("td", {}, label), ...plans.map(plan => make("td", { class: "number" }, of(plan))));
  return [make("div", { class: "scroll" }, make("table", {}, make("thead", {}, make("tr", {}, make("td", {}), ...names.map(name => make("th", {}, name)))), make("tbody", {},
    total("points", plan => String(plan.points)), total("bench time", plan => duration(plan.duration_s)), total("of it warming", plan => duration(plan.heating_s)), total("energy, kWh", plan => number(plan.energy_j / 3.6e6, 2)),
    ...differ.map(([name, a, b]) => make("tr", {}, make("td", {}, name), make("td", { class: "number" }, a ? `${a} ×` : "–"), make("td", { class: "number" }, b ? `${b} ×` : "–")))))),
    make("p", { class: "quiet" }, `${rows.length - differ.length} kinds of points are the same in both; ${differ.length} differ and are listed.`)];
}

async function load(name, keep) {
  const one = await acts.doIt(() => get(`campaigns/${encodeURIComponent(name)}/definition`), keep ? `${name} is in the form` : `a copy of ${name} is in the form`);
  if (one) edit(keep ? one.table : { ...one.table, name: `${one.table.name}-copy` }, keep ? name : null);
}

function edit(what, name) {
  table = what;
  origin = name;
  form();
  plan();
  $("plan-card").scrollIntoView({ behavior: "instant", block: "nearest" });
}

const changed = () => { clearTimeout(timer); timer = setTimeout(plan, AFTER_MS); };
const field = (label, value, act, more = {}) => make("label", { class: "field" }, label, make("input", { type: "text", value, ...more, on: { input: event => { act(event.target.value); changed(); } } }), more.hint ? make("small", { class: "quiet" }, more.hint) : null);
const select = (label, options, value, act) => make("label", { class: "field" }, label, make("select", { on: { change: event => { act(event.target.value); form(); changed(); } } }, ...options.map(one => make("option", { value: one, selected: one === value }, one.replaceAll("_", " ")))));
const small = (label, act, disabled = false) => make("button", { type: "button", class: "small", disabled, on: { click: () => { act(); form(); changed(); } } }, label);

// "0, 350 N*m": a number without a unit gets the usual one.
const withUnit = (text, kind) => /^[+-]?[\d.]+([eE][+-]?\d+)?$/.test(text) ? `${text} ${UNITS[kind] ?? ""}`.trim() : text;
const split = (text, kind) => text.split(",").map(part => part.trim()).filter(Boolean).map(part => withUnit(part.replace("−", "-"), kind));

function limitHint(key) {
  const { limits, ratio } = state.about;
  if (key === "load_torques") return `N·m if no unit is written; the bench takes ±${number(limits.load_torque, 0)} N·m`;
  if (key === "velocities") return `°/s if no unit is written; the bench takes ±${number(limits.motor_speed / ratio * DEGREES, 1)} °/s; − turns the other way`;
  return `°C if no unit is written, or “as found”; the bench takes ${number(limits.temperature, 0)} °C`;
}

function form() {
  $("plan-form").replaceChildren(
    field("Name, also of its file", table.name, value => { table.name = value; }, { id: "plan-name", maxlength: 80 }),
    field("Title", table.title, value => { table.title = value; }, { id: "plan-title" }),
    ...table.stages.map((stage, i) => stageForm(stage, i)),
    make("div", { class: "acts" }, small("Add a stage", () => table.stages.push({ name: `stage ${table.stages.length + 1}`, order: "temperature", points: [structuredClone(fresh().stages[0].points[0])] }))));
}

function stageForm(stage, i) {
  return make("fieldset", {}, make("legend", {}, `Stage ${i + 1}`),
    field("Name of the stage", stage.name, value => { stage.name = value; }),
    select("Order of its points", schema.$defs.Order.enum, stage.order ?? "temperature", value => { stage.order = value; }),
    ...stage.points.map((block, k) => blockForm(stage, block, k)),
    make("div", { class: "acts" }, small("Add measurements", () => stage.points.push(structuredClone(stage.points[stage.points.length - 1]))), small("Take this stage out", () => table.stages.splice(i, 1), table.stages.length < 2)));
}

function blockForm(stage, block, k) {
  const options = schema.$defs[block.sequence];
  return make("fieldset", { class: "block" },
    select("Measurement", schema.$defs.BlockSection.properties.sequence.enum, block.sequence, value => { block.sequence = value; delete block.options; }),
    make("p", { class: "quiet" }, options?.description ?? ""),
    ...Object.entries(VALUES).map(([key, kind]) => field(LABELS[key], (block[key] ?? schema.$defs.BlockSection.properties[key].default).join(", "), value => { block[key] = split(value, kind); }, { hint: limitHint(key), "data-key": key })),
    field("Repeats", String(block.repeats ?? 1), value => { block.repeats = whole(value); }, { inputmode: "numeric", "data-key": "repeats" }),
    ...Object.entries(options?.properties ?? {}).map(([key, one]) => field(key.replaceAll("_", " "), String(block.options?.[key] ?? ""), value => option(block, key, one, value.trim()),
      { placeholder: String(one.default ?? ""), hint: one.units ? `${one.units.slice(0, 4).join(", ")}; empty: ${one.default}` : `empty: ${one.default ?? "none"}`, "data-key": key })),
    make("div", { class: "acts" }, small("Take these out", () => stage.points.splice(k, 1), stage.points.length < 2)));
}

// What is no number is sent as it was written: the service says what would be right.
const whole = text => /^\d+$/.test(text.trim()) ? Number(text) : text;
function option(block, key, one, text) {
  const options = { ...block.options };
  if (!text) delete options[key];
  else options[key] = one.kind ? withUnit(text, one.kind) : Number.isFinite(Number(text)) ? Number(text) : text;
  if (Object.keys(options).length) block.options = options; else delete block.options;
}

async function plan() {
  const mine = ++asked;
  $("plan-problem").textContent = "";
  $("plan-sum").textContent = "plans …";
  try {
    const found = await post("plan", { table }, { id: false, tries: 2, within_ms: 60000 });
    if (mine === asked) planned(found);
  } catch (error) {
    if (mine !== asked) return;
    $("plan-problem").textContent = acts.sentence(error);
    $("plan-sum").textContent = "";
    $("plan-points").replaceChildren();
  }
  if (mine === asked) { $("plan-save").disabled = Boolean($("plan-problem").textContent); $("plan-start").disabled = !origin || $("plan-save").disabled; $("plan-hint").hidden = Boolean(origin); }
}

function planned(found) {
  $("plan-sum").textContent = planSum(found);
  $("plan-text").textContent = found.text;
  $("plan-points").replaceChildren(taskTable(found));
}

export const planSum = found => `${found.points} points · ${duration(found.duration_s)} of bench time, of it ${duration(found.heating_s)} warming · ${number(found.energy_j / 3.6e6, 2)} kWh · from ${number(found.start_temperature_degc, 1)} °C`;

// Every point of a plan with its begin, time, expected temperature, energy and motor torque.
export function taskTable(found) {
  const head = ["", "Measurement", "N·m", "°/s", "°C wanted", "Begins after", "Takes", "°C expected", "Wh", "Motor N·m"];
  const cell = text => make("td", { class: "number" }, text);
  return make("table", {}, make("thead", {}, make("tr", {}, ...head.map(name => make(name ? "th" : "td", {}, name)))), make("tbody", {}, ...found.tasks.map(task => make("tr", { class: task.preparation ? "quiet" : "" },
    cell(task.number || ""), make("td", {}, task.sequence.replaceAll("_", " "), task.repeat > 1 ? make("small", { class: "quiet" }, ` repeat ${task.repeat}`) : null),
    cell(number(task.load_torque_nm, 0)), cell(number(task.velocity_rad_s * DEGREES, 1)), cell(task.temperature_degc === null ? "as found" : number(task.temperature_degc, 1)),
    cell(duration(task.start_s)), cell(duration(task.duration_s)), cell(number(task.expected_end_temperature_degc, 1)), cell(number(task.energy_j / 3600, 1)), cell(number(task.expected_motor_torque_nm, 2))))));
}

function save() {
  const who = make("input", { type: "text", maxlength: 40, value: me.name }), wanted = () => `${table.name}.toml`;
  const keep = async replaces => {
    me.name = who.value.trim() || me.name;
    const answer = await post("campaigns", { name: me.name, campaign: wanted(), table, replaces });
    origin = answer.campaign;
    $("plan-start").disabled = false;
    $("plan-hint").hidden = true;
    show();
    return answer;
  };
  acts.sheet("Save as a campaign of the laboratory", [make("p", {}, `It is kept as ${wanted()} and offered wherever campaigns are started.`), make("label", { class: "field" }, "Your name, for the record", who)],
    [["Save", async () => {
      try { return await keep(origin === wanted()); } catch (error) {
        if (!(error instanceof Refused) || !error.message.includes("already")) throw error;
        throw new Refused(`${error.message}. “Replace it” keeps the version before beside it.`);
      }
    }], ["Replace it", () => keep(true), ""]]);
}
