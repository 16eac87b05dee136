import type { Context } from "../context.js";
import type { FromServer, Pose } from "../live/messages.js";

/** What the server rounds a pose to: 10 µm, 0.001°. */
const SAME_POSITION = 2e-5;
const SAME_ROTATION_DEG = 2e-3;

type Outcome = { readonly failure: string | null };

/**
 * Has the scene solved for where the props really stand, however often the server goes and comes back
 * meanwhile; done when the warp of that scene is here.
 */
export class Resolver {
  /** 0 to 1; null while nothing is known of it. */
  progress: number | null = null;
  /** What is being done, for the person. */
  step = "";
  #wanted: Readonly<Record<string, Pose>> | null = null;
  #outcome: Outcome | null = null;
  #unlisten: (() => void)[] = [];

  constructor(readonly context: Context) {
    this.#unlisten.push(context.listen((message) => this.#hear(message)));
  }

  /** Ask for these props to be moved. */
  begin(poses: Readonly<Record<string, Pose>>): void {
    this.#wanted = poses;
    this.#outcome = null;
    this.progress = null;
    this.step = "";
    this.#ask();
  }

  /** What has become of it, once. */
  take(): Outcome | null {
    const { state, tables } = this.context;
    if (this.#wanted && this.#isAsWanted() && state.warp_current && tables.exact) {
      this.#end({ failure: null });
    }
    const outcome = this.#outcome;
    this.#outcome = null;
    return outcome;
  }

  /** It is not wanted any more. */
  cancel(): void {
    this.#wanted = this.#outcome = null;
  }

  dispose(): void {
    for (const unlisten of this.#unlisten) unlisten();
  }

  #hear(message: FromServer): void {
    if (this.#wanted === null) return;
    if (message.kind === "progress" && message.task !== "check") {
      this.progress = message.done;
      this.step = message.step;
    } else if (message.kind === "failed" && message.task === "solve") {
      this.#end({ failure: message.reason });
    } else if (message.kind === "refused" && message.about === "change_scene") {
      this.#end({ failure: message.reason });
    } else if (message.kind === "state" && !this.#isAsWanted()) {
      this.#ask(); // a server that has come back knows nothing of it
    }
  }

  #ask(): void {
    const { connection } = this.context;
    if (!connection) {
      this.#end({ failure: "There is no server to solve on." });
      return;
    }
    if (this.#isAsWanted()) return;
    const sent = connection.send({ kind: "change_scene", poses: this.#wanted! });
    if (!sent) this.step = "waiting for the server";
  }

  #isAsWanted(): boolean {
    return Object.entries(this.#wanted!).every(([name, pose]) => {
      const prop = this.context.state.props.find((each) => each.name === name);
      return prop !== undefined && isSame(prop.pose, pose);
    });
  }

  #end(outcome: Outcome): void {
    this.#wanted = null;
    this.#outcome = outcome;
  }
}

function isSame(one: Pose, other: Pose): boolean {
  const apart = (a: readonly number[], b: readonly number[]) =>
    Math.max(...a.map((value, k) => Math.abs(value - b[k]!)));
  return (
    apart(one.position, other.position) < SAME_POSITION &&
    apart(one.rotation_deg, other.rotation_deg) < SAME_ROTATION_DEG
  );
}
