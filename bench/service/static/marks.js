// What stands on a plot beside its curves: limits, remarks and alarms; and what is shown, saved as a picture or as values.

// Lines at the limits of the bench, where they lie within what is shown.
export function limitLines(u, limits, colour) {
  const { ctx, bbox } = u, [low, high] = [u.scales.y.min, u.scales.y.max];
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = colour("bad");
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.font = `600 ${13 * devicePixelRatio}px system-ui, sans-serif`;
  for (const value of limits) {
    if (!(value >= low && value <= high)) continue;
    const y = u.valToPos(value, "y", true);
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
    ctx.fillText("limit", bbox.left + 4 * devicePixelRatio, y - 4 * devicePixelRatio);
  }
  ctx.restore();
}

// A number at each moment something was said; the list beside the plots says what.
export function markLines(u, marks, colour) {
  const { ctx, bbox } = u, [low, high] = [u.scales.x.min, u.scales.x.max];
  ctx.save();
  ctx.font = `600 ${13 * devicePixelRatio}px system-ui, sans-serif`;
  for (const { time, label, level } of marks) {
    if (!(time >= low && time <= high)) continue;
    const x = u.valToPos(time, "x", true);
    ctx.strokeStyle = ctx.fillStyle = colour(level === "error" ? "bad" : level === "warning" ? "set" : "quiet");
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([4 * devicePixelRatio, 4 * devicePixelRatio]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.fillText(label, x + 3 * devicePixelRatio, bbox.top + 13 * devicePixelRatio);
  }
  ctx.restore();
}

// The part of each curve that is shown, one line a value.
export function values(plots) {
  const lines = ["plot,series,x,value"], quoted = text => `"${String(text).replaceAll("\"", "\"\"")}"`;
  for (const { plot, title } of plots) {
    if (!plot) continue;
    const { min, max } = plot.scales.x, [x, ...columns] = plot.data;
    columns.forEach((column, i) => x.forEach((at, k) => {
      if (at >= min && at <= max && column[k] !== null && column[k] !== undefined) lines.push([quoted(title), quoted(plot.series[i + 1].label), at, column[k]].join(","));
    }));
  }
  return `${lines.join("\n")}\n`;
}

const MARGIN = 10, LINE = 22, SWATCH = 28, GAP = 16;

// Words of a text in lines of a width.
function broken(ctx, text, width) {
  const lines = [""];
  for (const word of text.split(" ")) {
    const longer = `${lines.at(-1)} ${word}`.trim();
    if (!lines.at(-1) || ctx.measureText(longer).width <= width) lines[lines.length - 1] = longer; else lines.push(word);
  }
  return lines.filter(Boolean);
}

// A text, or as much of it as a width holds.
function fitted(ctx, text, width) {
  let cut = text;
  while (cut && ctx.measureText(cut === text ? cut : `${cut}…`).width > width) cut = cut.slice(0, -1);
  return cut === text ? text : `${cut}…`;
}

// What a plot's key says, in lines of a width: [name of the colour, label, kind] and where each begins.
function keyLines(ctx, entries, width, unit) {
  const lines = [[]];
  let x = 0;
  for (const [name, text, kind] of entries) {
    const entry = [name, fitted(ctx, text, width - (SWATCH + 8) * unit), kind], size = (SWATCH + 8 + GAP) * unit + ctx.measureText(entry[1]).width;
    if (x + size > width && lines.at(-1).length) { lines.push([]); x = 0; }
    lines.at(-1).push({ entry, x });
    x += size;
  }
  return lines.filter(line => line.length);
}

function keyEntry(ctx, [name, label, kind], x, y, unit, colour) {
  const middle = y - 5 * unit, size = SWATCH * unit;
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = colour(name);
  ctx.lineWidth = 3 * unit;
  ctx.beginPath();
  if (kind === "area") ctx.fillRect(x, middle - 6 * unit, size, 12 * unit);
  else if (kind === "ring") ctx.arc(x + size / 2, middle, 6 * unit, 0, 2 * Math.PI);
  else { if (kind === "dash") ctx.setLineDash([6 * unit, 4 * unit]); ctx.moveTo(x, middle); ctx.lineTo(x + size, middle); }
  if (kind !== "area") ctx.stroke();
  ctx.restore();
  ctx.fillText(label, x + size + 8 * unit, y);
}

// The plots below each other on one canvas, each below its title and its key; the caption says of what they are.
export function picture(plots, colour, caption = "") {
  const drawn = plots.filter(one => one.plot), unit = devicePixelRatio, canvas = document.createElement("canvas"), ctx = canvas.getContext("2d");
  const bold = `600 ${16 * unit}px system-ui, sans-serif`, plain = `${14 * unit}px system-ui, sans-serif`;
  canvas.width = Math.max(1, ...drawn.map(one => one.plot.ctx.canvas.width));
  const width = canvas.width - 2 * MARGIN * unit;
  ctx.font = plain;
  const head = broken(ctx, caption, width), keys = drawn.map(one => keyLines(ctx, one.entries ?? [], width, unit));
  ctx.font = bold;
  const titles = drawn.map(one => broken(ctx, one.title, width));
  const heights = drawn.map((one, i) => (titles[i].length + keys[i].length) * LINE * unit + MARGIN * unit + one.plot.ctx.canvas.height);
  canvas.height = Math.max(1, head.length * LINE * unit + heights.reduce((sum, one) => sum + one, 0));
  ctx.fillStyle = colour("card");
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  ctx.fillStyle = colour("ink");
  let y = 0;
  const line = (font, write) => { y += LINE * unit; ctx.font = font; write(y - 5 * unit); };
  for (const text of head) line(plain, at => ctx.fillText(text, MARGIN * unit, at));
  drawn.forEach(({ plot }, i) => {
    for (const text of titles[i]) line(bold, at => ctx.fillText(text, MARGIN * unit, at));
    for (const entries of keys[i]) line(plain, at => entries.forEach(({ entry, x }) => keyEntry(ctx, entry, MARGIN * unit + x, at, unit, colour)));
    ctx.drawImage(plot.ctx.canvas, 0, y + MARGIN * unit);
    y += MARGIN * unit + plot.ctx.canvas.height;
  });
  return canvas;
}

const colourOf = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const clean = name => name.replace(/[^\w.+-]+/g, "-");

function give(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = clean(name);
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export const savePicture = (plots, name, caption) => picture(plots, colourOf, caption).toBlob(blob => give(blob, `${name}.png`), "image/png");
export const saveValues = (plots, name) => give(new Blob([values(plots)], { type: "text/csv" }), `${name}.csv`);
