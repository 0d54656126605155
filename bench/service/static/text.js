// Numbers, times and small pieces of the page. Local time is shown; what is stored is UTC.

export const $ = id => document.getElementById(id);

export function make(tag, attributes = {}, ...content) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "on") for (const [event, act] of Object.entries(value)) element.addEventListener(event, act);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...content.filter(part => part !== null && part !== undefined));
  return element;
}

export const DEGREES = 180 / Math.PI;
export const number = (value, digits) => value === null || value === undefined || !Number.isFinite(value) ? "–"
  : (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits).replace("-", "−");

export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const s = Math.max(0, Math.round(seconds));
  if (s < 90) return `${s} s`;
  if (s < 5400) return `${Math.round(s / 60)} min`;
  const minutes = Math.round(s / 60);
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
}

export const clock = seconds => new Date(seconds * 1000).toLocaleTimeString([], { hour: "2-digit", minute: "2-digit", hour12: false });
const two = n => String(n).padStart(2, "0");
export function moment(text) {
  const t = new Date(text), today = t.toDateString() === new Date().toDateString();
  const day = today ? "today" : `${t.getFullYear()}-${two(t.getMonth() + 1)}-${two(t.getDate())}`;
  return `${day} ${two(t.getHours())}:${two(t.getMinutes())}:${two(t.getSeconds())}`;
}
export const bytes = n => n > 1e12 ? `${(n / 1e12).toFixed(1)} TB` : n > 1e9 ? `${(n / 1e9).toFixed(1)} GB` : `${(n / 1e6).toFixed(1)} MB`;

export const setpoint = point => [
  point.load_torque === null || point.load_torque === undefined ? null : `${number(point.load_torque, 0)} N·m`,
  point.velocity === null || point.velocity === undefined ? null : `${number(point.velocity * DEGREES, 1)} °/s`,
  point.temperature === null || point.temperature === undefined ? null : `${number(point.temperature, 1)} °C`,
].filter(Boolean).join(", ");

export function pill(state, text = state) {
  const kind = { done: "good", failed: "bad", running: "busy", heating: "busy", saving: "busy", skipped: "warn", "cut short": "warn", ended: "", queued: "", proposed: "warn", cancelled: "warn" }[state] ?? "";
  const sign = { done: "✓ ", failed: "✗ ", running: "▶ ", heating: "▲ ", skipped: "» ", "cut short": "» ", proposed: "? " }[state] ?? "";
  return make("span", { class: `pill ${kind}` }, sign + text);
}

export function choice(place, options, chosen, act) {
  const show = value => { for (const button of place.children) button.setAttribute("aria-checked", button.dataset.value === String(value)); };
  place.replaceChildren(...options.map(([value, label]) => make("button", {
    type: "button", role: "radio", "data-value": value, on: { click: () => { show(value); act(value); } },
  }, label)));
  show(chosen);
}

let timer;
export function toast(text) {
  const place = $("toast");
  place.textContent = text;
  place.hidden = false;
  clearTimeout(timer);
  timer = setTimeout(() => { place.hidden = true; }, 6000);
}
