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
  /** Whether the server may not have what was sent last. */
  #inDoubt = false;
  /** Whether the server has told its scene since the connection opened. */
  #met = false;
  #saving = false;
  #revision = -1;

  constructor(readonly connection: Connection | null) {
    connection?.listen((message) => this.#hear(message));
    connection?.listenStatus(() => {
      this.#met = false;
      if (this.#inDoubt) this.#unsent = true; // it may have got lost on the way
    });
  }

  /** Change the scene; what is not given stays. */
  ask(change: Change): void {
    this.#unsaved = merged(this.#unsaved, change);
    this.#inDoubt = true;
    const sent = this.connection?.send({ kind: "change_scene", ...change });
    if (sent === false) this.#unsent = true;
  }

  /** Save the scene to its file, once the server has all changes. */
  save(): void {
    const sent = this.#met && !this.#unsent && this.connection?.send({ kind: "save_scene" });
    this.#saving = !sent;
  }

  #hear(message: FromServer): void {
    if (message.kind === "refused" && message.about === "change_scene") {
      this.#unsaved = {};
      this.#inDoubt = false;
    }
    if (message.kind !== "state") return;
    const anew = message.revision < this.#revision;
    if (message.revision > this.#revision) this.#inDoubt = false;
    this.#revision = message.revision;
    this.#met = true;
    if (anew || this.#unsent) this.#sendAll();
    else if (!message.unsaved) this.#unsaved = {};
    if (this.#saving) this.save();
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
