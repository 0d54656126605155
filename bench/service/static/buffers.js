// Live values in bounded memory: a fine ring and a coarse one, and at most so many points as a screen can show.

const FINE = 3300, COARSE = 4320, COARSE_S = 10;
export const MOST_POINTS = 500;
const GAP_S = 1.5;

export function merge(parts) {
  const values = {};
  let total = 0;
  for (const part of parts) {
    const weight = Math.max(part.end - part.start, 1e-9);
    total += weight;
    for (const [name, [low, high, mean, last]] of Object.entries(part.values)) {
      const sum = values[name];
      if (!sum) values[name] = [low, high, mean * weight, last];
      else { sum[0] = Math.min(sum[0], low); sum[1] = Math.max(sum[1], high); sum[2] += mean * weight; sum[3] = last; }
    }
  }
  for (const sum of Object.values(values)) sum[2] /= total;
  return { start: parts[0].start, end: parts[parts.length - 1].end, values };
}

// Where nothing was read for a while an empty bucket stands, so that no line is drawn over it.
export function withGaps(buckets) {
  const out = [];
  for (const bucket of buckets) {
    const before = out[out.length - 1];
    if (before && bucket.start - before.end > GAP_S) out.push({ start: before.end, end: bucket.start, values: {} });
    out.push(bucket);
  }
  return out;
}

export class Buffers {
  constructor() { this.clear(); }

  clear() { this.fine = []; this.coarse = []; this.open = []; }

  load(fine, coarse) { this.fine = fine.slice(-FINE); this.coarse = coarse.slice(-COARSE); this.open = []; }

  add(bucket) {
    const last = this.last();
    if (last && bucket.start < last.start) this.clear();
    this.fine.push(bucket);
    // In lumps: shifting one by one would copy the whole array each time.
    if (this.fine.length > FINE * 1.2) this.fine = this.fine.slice(-FINE);
    this.open.push(bucket);
    if (bucket.end - this.open[0].start >= COARSE_S) {
      this.coarse.push(merge(this.open));
      this.open = [];
      if (this.coarse.length > COARSE * 1.2) this.coarse = this.coarse.slice(-COARSE);
    }
  }

  last() { return this.fine[this.fine.length - 1] ?? null; }

  // The last `seconds` as columns: time in the middle of each bucket, and per channel low, high, mean.
  window(seconds, names) {
    const last = this.last();
    if (!last) return null;
    const from = last.end - seconds;
    const enough = this.fine[0].start <= from || !this.coarse.length || this.fine[0].start <= this.coarse[0].start;
    let buckets = enough ? this.fine : [...this.coarse, ...this.open];
    buckets = buckets.filter(bucket => bucket.end >= from);
    const group = Math.ceil(buckets.length / MOST_POINTS);
    if (group > 1) {
      const merged = [];
      for (let i = 0; i < buckets.length; i += group) merged.push(merge(buckets.slice(i, i + group)));
      buckets = merged;
    }
    buckets = withGaps(buckets);
    const out = { time: buckets.map(bucket => (bucket.start + bucket.end) / 2), end: last.end };
    for (const name of names) {
      out[name] = [0, 1, 2].map(column => buckets.map(bucket => bucket.values[name]?.[column] ?? null));
    }
    return out;
  }
}
