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

// The plots below each other on one canvas, each below its title.
export function picture(plots, colour) {
  const drawn = plots.filter(one => one.plot), head = 30 * devicePixelRatio, canvas = document.createElement("canvas");
  canvas.width = Math.max(1, ...drawn.map(one => one.plot.ctx.canvas.width));
  canvas.height = Math.max(1, drawn.reduce((sum, one) => sum + one.plot.ctx.canvas.height + head, 0));
  const ctx = canvas.getContext("2d");
  ctx.fillStyle = colour("card");
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  ctx.fillStyle = colour("ink");
  ctx.font = `600 ${16 * devicePixelRatio}px system-ui, sans-serif`;
  let y = 0;
  for (const { plot, title } of drawn) {
    ctx.fillText(title, 10 * devicePixelRatio, y + head * 0.7);
    ctx.drawImage(plot.ctx.canvas, 0, y + head);
    y += plot.ctx.canvas.height + head;
  }
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

export const savePicture = (plots, name) => picture(plots, colourOf).toBlob(blob => give(blob, `${name}.png`), "image/png");
export const saveValues = (plots, name) => give(new Blob([values(plots)], { type: "text/csv" }), `${name}.csv`);
