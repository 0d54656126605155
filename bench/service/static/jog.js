// By hand: the torque sensor is tared; and a motion, with a button that is held. The page says so every 0.15 s; half a second of silence, and the run's own process stops.

import { post, Refused } from "./api.js";
import { sentence, sheet, STAY } from "./acts.js";
import { me, running, state } from "./state.js";
import { $, DEGREES, make, number } from "./text.js";

const EVERY_MS = 150;
let motion = null;

export function jog() {
  const most = state.about.jog_speed;
  const speed = make("input", { type: "range", id: "jog-speed", min: 5, max: 100, step: 5, value: 50 });
  const told = make("output", { for: "jog-speed" });
  const show = () => { told.textContent = `${number(speed.value / 100 * most * DEGREES, 2)} °/s of the load side`; };
  speed.addEventListener("input", show);
  show();
  const hold = (sign, label) => {
    const button = make("button", { type: "button", class: "hold", "data-jog": sign, "aria-describedby": "jog-text" }, label);
    const press = event => { event.preventDefault(); begin(sign * speed.value / 100 * most, button); };
    button.addEventListener("pointerdown", event => { button.setPointerCapture?.(event.pointerId); press(event); });
    button.addEventListener("keydown", event => { if ([" ", "Enter"].includes(event.key) && !event.repeat) press(event); });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture", "keyup", "blur", "contextmenu"]) button.addEventListener(name, () => end());
    return button;
  };
  sheet("Move by hand", [
    make("p", { id: "jog-text" }, "It turns as long as you hold the button, without load, at low torque, one revolution of the load side at most. Nothing is recorded. First the drives are switched on: keep holding."),
    make("label", { class: "field" }, "Speed", speed, told),
    make("div", { class: "acts" }, hold(-1, "◀ Hold: negative"), hold(1, "Hold: positive ▶")),
    make("p", { id: "jog-state", class: "big", role: "status" }, "Nothing moves."),
  ], []);
}

// The zero is taken at rest, without torque; the sheet waits for what was measured.
export function tare() {
  const told = make("p", { id: "tare-text", class: "big", role: "status" }, "");
  sheet("Tare the torque sensor", [
    make("p", {}, "Take every load off the gearbox first. The sensor is read for two seconds at rest; the drives have no voltage and nothing moves."),
    make("p", { class: "quiet" }, "The values shown between runs use this zero. A campaign does not: it measures a zero by a slow motion before and after its points."),
    told,
  ], [["Tare", async () => {
    told.textContent = "The bench is opened …";
    const { id } = await post("tare", { secret: me.secret });
    for (;;) {
      const run = state.runs.find(one => one.id === id);
      if (run?.state === "ended") { told.textContent = run.end.text; break; }
      if (running()?.id === id && state.status.phase === "taring") told.textContent = "The sensor is read …";
      await new Promise(resolve => setTimeout(resolve, 100));
    }
    return STAY;
  }]]);
}

const say = text => { if ($("jog-state")) $("jog-state").textContent = text; };

async function begin(velocity, button) {
  if (motion) return;
  const mine = motion = { run: null, held: true, button };
  button.classList.add("held");
  say("The drives are brought up; keep holding …");
  try {
    mine.run = (await post("jog", { secret: me.secret, velocity }, { tries: 1 })).id;
    // one after the other: what waits behind a slow answer would be said too late to be true
    while (mine.held) {
      const asked = Date.now();
      await post("jog/hold", { secret: me.secret, run: mine.run, held: true }, { id: false, tries: 1, within_ms: 1000 });
      if (state.status.phase === "by_hand" && running()?.id === mine.run) say("It moves. Let go and it stops.");
      await new Promise(resolve => setTimeout(resolve, Math.max(0, EVERY_MS - (Date.now() - asked))));
    }
    say("Let go: it is brought to rest.");
  } catch (error) { say(error instanceof Refused ? error.message : sentence(error)); }
  end(mine);
  if (mine.run) post("jog/hold", { secret: me.secret, run: mine.run, held: false }, { id: false, tries: 1 }).catch(() => { /* its silence says the same half a second later */ });
  motion = null;
}

function end(which = motion) {
  if (!which) return;
  which.held = false;
  which.button.classList.remove("held");
}

// A page nobody sees holds nothing.
document.addEventListener("visibilitychange", () => { if (document.hidden) end(); });
addEventListener("blur", () => end());
addEventListener("pagehide", () => end());
