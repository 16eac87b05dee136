import type { Connection } from "./connection.js";
import type { ChangeScene, FromServer } from "./messages.js";

type Change = Omit<ChangeScene, "kind" | "number">;

/**
 * How far the last change has come: it waits for the server, is on its way, or the server has told
 * a scene that holds it. What was on its way when the connection changed may be lost: it waits again.
 *
 *     waiting ──server met──▶ sent ──its scene, or refused──▶ arrived
 *        ▲                     │                                │
 *        └──connection changes─┴──────server begun anew─────────┘
 */
type Delivery = "waiting" | "sent" | "arrived";

/**
 * What the person has changed in the scene, on its way to the server. A change that is made while the
 * server is gone is sent when it is back, and all that was not saved once more when it has begun anew.
 */
export class Changes {
  /** Everything since the scene was last as its file says. */
  #unsaved: Change = {};
  #delivery: Delivery = "arrived";
  /** Whether it has told its scene since the connection changed. */
  #server: "away" | "met" = "away";
  #revision = -1;
  /** The number of the change sent last. */
  #number = 0;
  /** From which revision on the server has that; until it tells, none. */
  #taken = Number.POSITIVE_INFINITY;
  #save: "none" | "wanted" = "none";

  constructor(readonly connection: Connection | null) {
    connection?.listen((message) => this.#hear(message));
    connection?.listenStatus(() => {
      this.#server = "away";
      if (this.#delivery === "sent") this.#delivery = "waiting";
    });
  }

  /** Whether the scene that the server has told may be older than what the person has changed. */
  get pending(): boolean {
    return this.#delivery !== "arrived";
  }

  /** Change the scene; what is not given stays. */
  ask(change: Change): void {
    this.#unsaved = merged(this.#unsaved, change);
    this.#send(change);
  }

  /** Save the scene to its file, once the server has all changes. */
  save(): void {
    const ready = this.#server === "met" && this.#delivery !== "waiting";
    const sent = ready && this.connection?.send({ kind: "save_scene" });
    this.#save = sent ? "none" : "wanted";
  }

  #hear(message: FromServer): void {
    if (message.kind === "refused" && message.about === "change_scene") {
      this.#unsaved = {};
      this.#delivery = "arrived";
    }
    if (message.kind === "changed" && message.number === this.#number) {
      this.#taken = message.revision;
      this.#arrive();
    }
    if (message.kind !== "state") return;
    const { revision, unsaved } = message;
    const anew = revision < this.#revision;
    this.#revision = revision;
    this.#arrive();
    this.#server = "met";
    if (anew || this.#delivery === "waiting") this.#send(this.#unsaved);
    else if (!unsaved && this.#delivery === "arrived") this.#unsaved = {};
    if (this.#save === "wanted") this.save();
  }

  #arrive(): void {
    if (this.#delivery === "sent" && this.#revision >= this.#taken) this.#delivery = "arrived";
  }

  #send(change: Change): void {
    if (Object.keys(change).length === 0) {
      this.#delivery = "arrived";
      return;
    }
    const number = ++this.#number;
    this.#taken = Number.POSITIVE_INFINITY;
    const sent = this.connection?.send({ kind: "change_scene", number, ...change });
    const waits = sent === false || (this.#delivery === "waiting" && change !== this.#unsaved);
    this.#delivery = waits ? "waiting" : "sent";
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
