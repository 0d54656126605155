// Plots with uPlot: bands of minimum and maximum, set values, order spectra. Colours come from the style sheet.

import { limitLines, markLines } from "./marks.js";
import { number } from "./text.js";

const uPlot = () => window.uPlot;
const colour = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const all = new Set();

export function redraw() { for (const plot of all) plot.rebuild(); }

class Plot {
  constructor(place, height, options, sync = null) {
    this.sync = sync;
    this.place = place; this.height = height; this.options = options; this.data = null; this.plot = null; this.range = null; this.zoom = null; this.limits = []; this.marks = []; this.onZoom = null; this.title = "";
    all.add(this);
    this.watch = new ResizeObserver(() => this.fit());
    this.watch.observe(place);
  }

  fit() {
    const width = this.place.clientWidth;
    if (!width) return;
    if (!this.plot) { if (this.data) this.rebuild(); }
    else if (Math.abs(this.plot.width - width) > 1) this.plot.setSize({ width, height: this.height });
  }

  rebuild() {
    this.plot?.destroy();
    this.plot = null;
    const width = this.place.clientWidth;
    if (!width || !this.data) return;
    this.plot = new (uPlot())({ width, height: this.height, ...this.options(this), cursor: this.cursor(), select: { show: true }, legend: { show: true } }, this.data, this.place);
    this.plot.over.addEventListener("wheel", event => this.wheel(event), { passive: false });
  }

  // In a stretch that was chosen the wheel goes along it; without one it scrolls the page.
  wheel(event) {
    if (!this.zoom) return;
    event.preventDefault();
    const by = (event.deltaX || event.deltaY) / this.plot.over.clientWidth * (this.zoom[1] - this.zoom[0]);
    this.zoom = this.zoom.map(end => end + by);
    this.plot.setData(this.plot.data);
    if (!this.onZoom) return;
    // its own detail is asked for once the wheel rests
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.onZoom(this.zoom), 250);
  }

  // Drag over a stretch to look into it, click twice for all of it: what arrives meanwhile leaves the stretch alone.
  cursor() {
    return {
      drag: { x: true, y: false, setScale: false, dist: 8 },
      ...(this.sync ? { sync: { key: this.sync } } : {}),
      bind: { dblclick: u => () => this.look(u, null) },
    };
  }

  hooks(more = {}) {
    return { ...more, setSelect: [u => {
      if (u.select.width < 8) return;
      this.look(u, [u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")]);
      u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    }] };
  }

  look(u, stretch) {
    if (this.onZoom) return this.onZoom(stretch);
    this.zoom = stretch;
    this.place.classList.toggle("zoomed", stretch !== null);
    u.setData(u.data);
  }

  show(data, range = null) {
    this.data = data; this.range = range;
    if (!this.place.clientWidth) return;
    if (!this.plot || this.plot.data.length !== data.length) this.rebuild();
    else this.plot.setData(data);
  }

  drop() { this.plot?.destroy(); this.plot = null; all.delete(this); this.watch.disconnect(); }

  resize(height) {
    if (Math.abs(height - this.height) < 2) return;
    this.height = height;
    this.plot?.setSize({ width: this.plot.width, height });
  }
}

const axis = (more = {}) => ({
  stroke: colour("quiet"), font: "15px system-ui, sans-serif", labelFont: "15px system-ui, sans-serif",
  grid: { stroke: colour("grid"), width: 1 }, ticks: { stroke: colour("grid"), width: 1 }, ...more,
});
const short = value => value === null || value === undefined ? "–" : Number(value.toPrecision(4)).toString().replace("-", "−");
const padded = least => (self, low, high) => {
  if (low === null || high === null) return [0, 1];
  const middle = (low + high) / 2, half = Math.max((high - low) * 0.55, least);
  return [middle - half, middle + half];
};

// Columns: time, set or expected, low, high, mean; with `other`, the mean of a second recording last.
export function bandPlot(place, { title, set = "set", actual = "mean", least = 0.1, height = 170, clockTime = true, other = null, sync = null }) {
  const entries = key(place, title, [["actual", actual, "stroke"], ...(set ? [["set", set, "dash"]] : []), ...(other ? [["model", other, "stroke"]] : []), ["band", "min … max", "area"]]);
  const hidden = { points: { show: false }, value: (u, v) => short(v) };
  const plot = new Plot(place, height, self => ({
    scales: {
      x: { time: clockTime, range: (u, low, high) => self.zoom ?? self.range ?? [low, high === low ? low + 1 : high] },
      y: { range: padded(least) },
    },
    axes: [axis({ space: clockTime ? 95 : 60, values: clockTime ? [[3600, "{HH}:{mm}"], [60, "{HH}:{mm}"], [1, "{HH}:{mm}:{ss}"], [0.001, "{HH}:{mm}:{ss}"]] : undefined }), axis({ size: 70 })],
    series: [{ label: clockTime ? "time" : "s", value: (u, v) => v === null ? "–" : clockTime ? new Date(v * 1000).toLocaleTimeString([], { hour12: false }) : short(v) },
      { label: "min", stroke: colour("band"), width: 1, ...hidden }, { label: "max", stroke: colour("band"), width: 1, ...hidden },
      { label: actual, stroke: colour("actual"), width: 2.5, ...hidden },
      ...(set ? [{ label: set, stroke: colour("set"), width: 2.5, dash: [9, 7], spanGaps: true, ...hidden }] : []),
      ...(other ? [{ label: other, stroke: colour("model"), width: 2, ...hidden }] : [])],
    bands: [{ series: [2, 1], fill: colour("band") }],
    hooks: self.hooks({ draw: [u => limitLines(u, self.limits, colour), u => markLines(u, self.marks, colour)] }),
  }), sync);
  titled(title, entries, plot);
  const show = plot.show.bind(plot);
  // drawn last, the set value stays in sight over what follows it well
  plot.show = ([time, wanted, low, high, mean, second], range) => show([time, low, high, mean, ...(set ? [wanted] : []), ...(other ? [second] : [])], range);
  return plot;
}

function key(place, title, entries) {
  const line = document.createElement("div");
  line.className = "key";
  const strong = document.createElement("b");
  strong.textContent = title;
  line.append(strong, ...entries.map(([name, label, kind]) => {
    const item = document.createElement("span");
    item.className = `${kind} of-${name}`;
    item.textContent = label;
    return item;
  }));
  place.before(line);
  return entries;
}

// Columns: order, measured amplitude, model amplitude (may be all null); µrad.
export function spectrumPlot(place, height = 330, second = "model") {
  const entries = key(place, "Order spectrum", [["actual", "measured", "area"], ["model", second, "ring"]]);
  const label = u => {
    const [orders, measured] = u.data, { ctx } = u;
    const [from, to] = [u.scales.x.min, u.scales.x.max];
    const seen = orders.map((_, i) => i).filter(i => orders[i] >= from && orders[i] <= to && measured[i] !== null);
    ctx.save();
    ctx.fillStyle = colour("ink");
    ctx.font = `600 ${15 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textAlign = "center";
    const placed = [];
    for (const i of seen.sort((a, b) => measured[b] - measured[a])) {
      const x = u.valToPos(orders[i], "x", true), y = u.valToPos(measured[i], "y", true) - 6 * devicePixelRatio;
      if (placed.some(other => Math.abs(other - x) < 34 * devicePixelRatio)) continue;
      ctx.fillText(String(orders[i]), x, y);
      placed.push(x);
      if (placed.length >= 7) break;
    }
    ctx.restore();
  };
  return titled("Order spectrum", entries, new Plot(place, height, self => ({
    scales: { x: { time: false, range: () => self.zoom ?? self.range ?? [0, 320] }, y: { range: (u, low, high) => [0, (high || 1) * 1.2] } },
    axes: [axis({ label: "order (times a load-side revolution)", labelSize: 22 }), axis({ label: "amplitude in µrad", size: 60, labelSize: 22 })],
    series: [
      { label: "order" },
      { label: "measured µrad", stroke: colour("actual"), fill: colour("actual"), paths: uPlot().paths.bars({ size: [0.7, 14] }), points: { show: false }, value: (u, v) => short(v) },
      { label: `${second} µrad`, stroke: colour("model"), width: 0, paths: () => null, points: { show: true, size: 9, width: 2, stroke: colour("model"), fill: "transparent", filter: (u, s, show) => null }, value: (u, v) => short(v) },
    ],
    hooks: self.hooks({ draw: [label] }),
  })));
}

// What a picture of the plot says beside it.
const titled = (title, entries, plot) => Object.assign(plot, { title, entries });

// Columns: input angle in degrees, measured, model, lower and upper end of its band; µrad, as the spectrum.
export function curvePlot(place, height = 210, second = "model", band = false) {
  const entries = key(place, "Over the revolution", [["actual", "measured", "stroke"], ["model", second, "dash"], ...(band ? [["model-band", "its band", "area"]] : [])]);
  const end = name => ({ label: `${second} ${name} µrad`, stroke: colour("model-band"), width: 1, points: { show: false }, value: (u, v) => short(v) });
  const plot = titled("Transmission error over the revolution", entries, new Plot(place, height, self => ({
    scales: { x: { time: false, range: () => self.zoom ?? [0, 360] }, y: { range: padded(10) } },
    axes: [axis({ label: "input angle θ in degrees", labelSize: 22, incrs: [15, 30, 45, 60, 90] }), axis({ label: "error in µrad", size: 60, labelSize: 22 })],
    series: [
      { label: "θ °", value: (u, v) => short(v) },
      { label: "measured µrad", stroke: colour("actual"), width: 1.5, points: { show: false }, value: (u, v) => short(v) },
      { label: `${second} µrad`, stroke: colour("model"), width: 1.5, dash: [6, 4], points: { show: false }, value: (u, v) => short(v) },
      ...(band ? [end("from"), end("to")] : []),
    ],
    ...(band ? { bands: [{ series: [4, 3], fill: colour("model-band") }] } : {}),
    hooks: self.hooks(),
  })));
  const show = plot.show.bind(plot);
  plot.show = (columns, range) => show(columns.slice(0, band ? 5 : 3), range);
  return plot;
}

export function showSpectrum(spectrum, curve, message) {
  const none = message.amplitude.map(() => null);
  const micro = values => values.map(value => value === null ? null : value * 1e6);
  spectrum.show([message.amplitude.map((_, i) => i + 1), micro(message.amplitude), message.model ? micro(message.model) : none], spectrum.range);
  const angles = message.curve.map((_, i) => (i + 0.5) * 360 / message.curve.length), empty = message.curve.map(() => null);
  const model = message.model_curve ?? empty, half = message.model_curve && message.model_band;
  const end = sign => half ? micro(model.map((value, i) => value + sign * half[i])) : empty;
  curve.show([angles, micro(message.curve), micro(model), end(-1), end(1)]);
}

// What is drawn of the model, and why a part of it is not.
export function modelText(message) {
  if (!message.model) return message.model_why ? `The model is not drawn: ${message.model_why}.` : "No model is drawn: choose one under Analysis, “Draw over the spectrum”, or let one watch the campaign.";
  const drawn = "Circles and dashes: the model at the same load, speed, temperature, direction and time.";
  if (!message.model_band) return `${drawn} No band: ${message.model_why}.`;
  return `${drawn} Band: where ${number(100 * message.model_band_share, 0)} % should lie from its standard deviations and its residual on the recordings it was fitted to (${number(message.model_left * 1e6, 1)} µrad RMS); ${number(100 * message.model_inside, 0)} % of this revolution do.`;
}
