// The service as the page sees it: changes by POST with an id of their own, what happens as server-sent events.

export class Refused extends Error {}

export const newId = () => Array.from(crypto.getRandomValues(new Uint8Array(16)), b => b.toString(16).padStart(2, "0")).join("");

async function answer(response) {
  const content = await response.json().catch(() => ({ problem: `the service answered ${response.status}` }));
  // whoever has no token is asked for it, once
  if (response.status === 401) document.dispatchEvent(new Event("token"));
  if (!response.ok) throw new Refused(content.problem || `the service answered ${response.status}`);
  return content;
}

export const get = async path => answer(await fetch(`/api/${path}`, { credentials: "same-origin" }));

export async function post(path, body = {}, { id = true, tries = 3, within_ms = 8000 } = {}) {
  // One id for all tries: what got through is not done twice.
  const content = JSON.stringify(id ? { request_id: newId(), ...body } : body);
  for (let left = tries - 1; ; left--) {
    try {
      const signal = AbortSignal.timeout ? AbortSignal.timeout(within_ms) : undefined;
      return await answer(await fetch(`/api/${path}`, {
        method: "POST", credentials: "same-origin", headers: { "Content-Type": "application/json" }, body: content, signal,
      }));
    } catch (error) {
      if (error instanceof Refused || left <= 0) throw error;
      await new Promise(done => setTimeout(done, 300));
    }
  }
}

export async function showToken() {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return;
  history.replaceState(null, "", location.pathname);
  await post("session", { token }, { id: false });
}

const SILENT_MS = 6000;

// Calls on(type, message) for everything that happens, and gone(since | null) when the service is lost or back.
export function listen(on, gone) {
  let source, heard = Date.now(), lost = null;
  const types = ["about", "state", "runs", "plan", "point", "status", "live", "spectrum", "condition", "unread", "analyses", "clear", "beat"];
  const connect = () => {
    source?.close();
    source = new EventSource("/api/events");
    for (const type of types) {
      source.addEventListener(type, event => {
        heard = Date.now();
        if (lost !== null) { lost = null; gone(null); on("back", {}); }
        if (type !== "beat") on(type, JSON.parse(event.data));
      });
    }
  };
  connect();
  setInterval(() => {
    if (Date.now() - heard < SILENT_MS) return;
    if (lost === null) { lost = heard; gone(lost); }
    // The browser gives up on its own after some errors; a new connection does not.
    if (source.readyState === EventSource.CLOSED || Date.now() - heard > 3 * SILENT_MS) { connect(); heard = Math.max(heard, Date.now() - 2 * SILENT_MS); }
  }, 1000);
}
