// STOP: sent to the service and to the run's own stop listener at the same time; what is not confirmed is said within 1 s.
//
// Confirmed is a press only when the run itself says so: its phase is "stopping" or it has ended, or its listener answers
// "stopping" or "at rest". That the service took the press is not enough: the run may hang.

import { me, running, state } from "./state.js";
import { $, make, moment, toast } from "./text.js";

const SAY_MS = 700; // with a busy browser still said within 1 s of the press
const AGAIN_MS = 400;
const TRY_MS = 8000;
const GIVE_UP_MS = 600000;
const LOOPBACK = ["127.0.0.1", "localhost", "[::1]"];
const HEARD = ["stopping", "at_rest", "not_seen"];

let press = null; // { at_ms, run, sent, confirmed, late } of the last press in this page

const sleep = ms => new Promise(done => setTimeout(done, ms));
const pending = () => press !== null && !press.confirmed && !press.nothing;

export function stop() {
  // stamped here, once: tries that come later carry the time of the press
  const at_ms = Date.now();
  if (pending()) return;
  press = { at_ms, run: running()?.id ?? null, sent: false, confirmed: false, nothing: false, late: false };
  const mine = press;
  $("stop").classList.add("sent");
  $("stop").textContent = "STOP …";
  throughService(mine);
  throughListener(mine);
  setTimeout(() => { if (mine === press && pending()) { mine.late = true; show(); } }, SAY_MS);
  show();
}

async function throughService(mine) {
  const body = JSON.stringify({ by: me.name || "somebody", pressed_at_ns: mine.at_ms * 1e6 });
  while (mine === press && pending() && Date.now() - mine.at_ms < GIVE_UP_MS) {
    try {
      const response = await fetch("/api/stop", { method: "POST", credentials: "same-origin", headers: { "Content-Type": "application/json" }, body, signal: AbortSignal.timeout(TRY_MS) });
      if (response.ok) {
        const answer = await response.json();
        mine.sent = true;
        if (answer.run === null) { mine.nothing = true; toast(`STOP: ${answer.done}`); }
        else mine.run = answer.run;
        settle(mine);
        return;
      }
    } catch { /* the next try, and the listener beside it */ }
    await sleep(AGAIN_MS);
  }
}

// The listener belongs to the run's process and is on this computer only; it works when the service hangs or is dead.
async function throughListener(mine) {
  const port = state.stop_port;
  if (!port || !LOOPBACK.includes(location.hostname)) return;
  const address = `http://127.0.0.1:${port}`;
  const over = () => mine !== press || mine.nothing || mine.seen?.state === "at_rest" || mine.seen?.state === "not_seen";
  let asked = false, failed = 0;
  while (!over() && Date.now() - mine.at_ms < GIVE_UP_MS && !(mine.confirmed && failed > 3)) {
    try {
      if (!asked) {
        const by = encodeURIComponent(me.name || "somebody");
        asked = (await fetch(`${address}/stop?by=${by}&pressed_at_ns=${mine.at_ms}000000`, { method: "POST", signal: AbortSignal.timeout(TRY_MS) })).ok;
      }
      const seen = await (await fetch(`${address}/state`, { signal: AbortSignal.timeout(TRY_MS) })).json();
      failed = 0;
      if (HEARD.includes(seen.state)) { mine.confirmed = true; mine.seen = seen; settle(mine); }
    } catch { failed += 1; /* not there (any more): the service may know why */ }
    await sleep(mine.confirmed ? AGAIN_MS / 2 : AGAIN_MS);
  }
}

function settle(mine) {
  if (mine !== press) return;
  if (!pending()) { $("stop").classList.remove("sent"); $("stop").textContent = "STOP"; }
  show();
}

// Is called with everything the service tells: the run says itself that it has heard.
export function heard() {
  if (press && pending() && !state.gone) {
    const run = state.runs.find(one => one.id === press.run);
    if (run ? run.state === "ended" || (run.state === "running" && ["stopping", "ended"].includes(state.status.phase)) : press.sent) {
      press.confirmed = true;
      return settle(press);
    }
  }
  show();
}

const rest = stopped => stopped.at_rest_after_s !== null ? `At rest after ${stopped.at_rest_after_s.toFixed(2)} s, seen on both shafts.`
  : stopped.at_rest && stopped.bench_to_rest_s !== null ? `Seen at rest on both shafts, ${stopped.bench_to_rest_s.toFixed(2)} s after the stop began by the bench's own time, which is not the clock's.`
  : stopped.at_rest ? "Seen at rest on both shafts; how long after the press is not known."
  : stopped.over ? "It was not observed whether the shafts are at rest: look at the bench." : "It has not been observed at rest yet.";

// One line below the header, on every page: who pressed, when, and what was seen since.
export function show() {
  const place = $("stopped"), late = pending() && press.late;
  place.classList.toggle("late", late);
  if (late) {
    place.hidden = false;
    place.replaceChildren(make("b", {}, "STOP not confirmed — use the emergency stop"),
      make("p", {}, press.sent ? "The service has sent it, but the run has not confirmed it. It is sent again." : "Neither the service nor the run has answered. It is sent again."));
    return;
  }
  // as long as the service knows nothing of it, what the run's own listener said
  const seen = press?.seen && (state.gone || state.stop?.run !== press.run) ? press.seen : null;
  const by = seen ? { by: seen.pressed_by ?? "somebody", pressed_at_ns: seen.pressed_at_ns ?? press.at_ms * 1e6, run: seen.run, at_rest: seen.state === "at_rest", at_rest_after_s: seen.at_rest_after_s ?? null, bench_to_rest_s: seen.bench_to_rest_s ?? null, over: seen.state === "not_seen" } : state.stop;
  place.hidden = !by || by.run === null;
  if (!place.hidden) place.replaceChildren(make("b", {}, `STOP pressed by ${by.by}, ${moment(by.pressed_at_ns / 1e6)}`), make("p", {}, rest(by)));
}
