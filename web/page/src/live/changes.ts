import type { Connection } from "./connection.js";
import type { ChangeScene, FromServer } from "./messages.js";

type Change = Omit<ChangeScene, "kind">;

/**
 * What the person has changed in the scene, on its way to the server. A change that is made while the
 * server is gone is sent when it is back, and all that was not saved once more when it has begun anew.
 */
export class Changes {
  /** Everything since the scene was last as its file says. */
  #unsaved: Change = {};
  #unsent = false;
  #revision = -1;

  constructor(readonly connection: Connection | null) {
    connection?.listen((message) => this.#hear(message));
  }

  /** Change the scene; what is not given stays. */
  ask(change: Change): void {
    this.#unsaved = merged(this.#unsaved, change);
    const sent = this.connection?.send({ kind: "change_scene", ...change });
    if (sent === false) this.#unsent = true;
  }

  #hear(message: FromServer): void {
    if (message.kind === "refused" && message.about === "change_scene") this.#unsaved = {};
    if (message.kind !== "state") return;
    const anew = message.revision < this.#revision;
    this.#revision = message.revision;
    if (anew || this.#unsent) this.#sendAll();
    else if (!message.unsaved) this.#unsaved = {};
  }

  #sendAll(): void {
    this.#unsent = false;
    if (Object.keys(this.#unsaved).length === 0) return;
    const sent = this.connection?.send({ kind: "change_scene", ...this.#unsaved });
    if (sent === false) this.#unsent = true;
  }
}

function merged(before: Change, after: Change): Change {
  return {
    ...before,
    ...after,
    ...(before.goals || after.goals ? { goals: { ...before.goals, ...after.goals } } : {}),
    ...(before.poses || after.poses ? { poses: { ...before.poses, ...after.poses } } : {}),
  };
}
