// What the page knows; changed by messages of the service only.
export const state = {
  about: { bench: "", title: "", ratio: 1, emulated: true, limits: {} },
  gone: false, holder: null, allowed: [], alarms: [], alive: true, model: null, stop: null, stop_port: null,
  runs: [], held: false, plan: null, points: new Map(), status: { phase: "free" }, spectrum: null, analyses: [], condition: null,
};

export const me = {
  get name() { return localStorage.getItem("name") || ""; },
  set name(value) { localStorage.setItem("name", value); },
  // The controls are a token, not a name: two browsers of one name are two.
  get secret() { return sessionStorage.getItem("secret"); },
  get lease() { return sessionStorage.getItem("lease"); },
  hold(secret, lease) { sessionStorage.setItem("secret", secret); sessionStorage.setItem("lease", lease); },
  letGo() { sessionStorage.removeItem("secret"); sessionStorage.removeItem("lease"); },
  get holds() { return Boolean(this.secret && state.holder && state.holder.id === this.lease); },
};

export const may = act => state.allowed.includes(act);
export const running = () => state.runs.find(run => run.state === "running");

// What stopped before its end and was not taken up since: the last run in its folder, resets of the bench apart.
export const unfinished = () => state.runs.filter((run, i) => run.state === "ended" && !run.resets && !run.by_hand && !run.tares && !["finished", "withdrawn", "refused"].includes(run.end.kind)
  && !state.runs.slice(i + 1).some(later => later.folder === run.folder && !later.resets && !["withdrawn", "refused"].includes(later.end?.kind)));
