import "./style.css";
import "./desk/desk.css";
import type { Context } from "./context.js";
import { type Desk, mountDesk } from "./desk/index.js";
import { Changes } from "./live/changes.js";
import { Connection } from "./live/connection.js";
import type { FromServer, SceneState } from "./live/messages.js";
import { Recorder } from "./live/recorder.js";
import { Tables } from "./live/tables.js";

const loading = document.querySelector("#loading")!;
/** ms after which a scene is taken to be one whose goal is still being made. */
const LONG = 4000;
setTimeout(() => {
  loading.textContent += " Its goal may take a minute to make; it is then kept.";
}, LONG);

async function start(): Promise<void> {
  const answer = await fetch("./boot.json", { cache: "no-store" });
  if (answer.status === 503) throw new Error(await answer.text()); // the server tells why
  if (!answer.ok) throw new Error(`The scene cannot be fetched (${answer.status}).`);
  let state = (await answer.json()) as SceneState;
  document.title = `${state.name} · touchwarp`;

  const listeners = new Set<(message: FromServer) => void>();
  const connection = state.live ? new Connection(socketAddress()) : null;
  const tables = new Tables();
  const context: Context = {
    get state() {
      return state;
    },
    connection,
    changes: new Changes(connection),
    tables,
    recorder: new Recorder(connection),
    listen(listener) {
      listeners.add(listener);
      return () => listeners.delete(listener);
    },
  };
  connection?.listen((message) => {
    if (message.kind === "state") {
      state = message;
      tables.update(state);
    }
    for (const listener of listeners) listener(message);
  });
  tables.update(state);
  const desk = await mountDesk(context);
  loading.remove();
  // for experiments and tests, as in the headset (xr/probe.ts)
  if (new URLSearchParams(location.search).has("probe")) window.touchwarpDesk = desk;
  const xr = await import("./xr/index.js");
  await xr.mountXr(context, desk.stage);
}

function socketAddress(): string {
  const address = new URL("./live", document.baseURI);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  return address.href;
}

start().catch((error: unknown) => {
  loading.remove();
  const place = document.querySelector("#trouble")!;
  place.textContent = error instanceof Error ? error.message : String(error);
  place.removeAttribute("hidden");
});

declare global {
  interface Window {
    touchwarpDesk?: Desk;
  }
}
