import { describe, expect, it } from "vitest";
import type { Context } from "../../src/context.js";
import type { FromPage, FromServer, Pose, SceneState } from "../../src/live/messages.js";
import { Resolver } from "../../src/xr/resolver.js";

const there: Pose = { position: [0.3, 0.01, 0], rotation_deg: [0, 0, 12] };
const here: Pose = { position: [0.3, 0, 0], rotation_deg: [0, 0, 0] };

/** A page's context whose server does what a test says. */
class Page {
  sent: FromPage[] = [];
  connected = true;
  exact = true;
  #listener = (_: FromServer) => {};
  state = this.sceneOf(here);
  readonly resolver: Resolver;

  constructor(live = true) {
    const page = this;
    const connection = {
      send(message: FromPage) {
        if (page.connected) page.sent.push(message);
        return page.connected;
      },
    };
    this.resolver = new Resolver({
      get state() {
        return page.state;
      },
      connection: live ? connection : null,
      tables: {
        get exact() {
          return page.exact;
        },
      },
      listen(listener: (message: FromServer) => void) {
        page.#listener = listener;
        return () => {};
      },
    } as unknown as Context);
  }

  sceneOf(pose: Pose, warp_current = false): SceneState {
    return { kind: "state", props: [{ name: "box", pose }], warp_current } as unknown as SceneState;
  }

  hear(message: FromServer): void {
    if (message.kind === "state") this.state = message;
    this.#listener(message);
  }
}

describe("solving for where props stand", () => {
  it("is done when the warp of that scene is here, not before", () => {
    const page = new Page();
    page.resolver.begin({ box: there });
    expect(page.sent).toEqual([{ kind: "change_scene", poses: { box: there } }]);
    expect(page.resolver.take()).toBeNull();
    page.hear(page.sceneOf(there));
    page.hear({ kind: "progress", task: "solve", step: "refining", done: 0.4 });
    expect([page.resolver.progress, page.resolver.step]).toEqual([0.4, "refining"]);
    page.hear({ kind: "progress", task: "check", step: "checking", done: 0.1 });
    expect(page.resolver.progress).toBe(0.4);
    page.exact = false;
    page.hear(page.sceneOf(there, true));
    expect(page.resolver.take()).toBeNull(); // its file is still on its way
    page.exact = true;
    expect(page.resolver.take()).toEqual({ failure: null });
    expect(page.resolver.take()).toBeNull();
  });

  it("knows its poses again after the server has rounded them", () => {
    const page = new Page();
    page.resolver.begin({ box: { ...there, position: [0.300004, 0.01, 0] } });
    page.hear(page.sceneOf(there, true));
    expect(page.sent).toHaveLength(1);
    expect(page.resolver.take()).toEqual({ failure: null });
  });

  it("asks a server again that has come back and forgotten", () => {
    const page = new Page();
    page.connected = false;
    page.resolver.begin({ box: there });
    expect([page.sent.length, page.resolver.step]).toEqual([0, "waiting for the server"]);
    page.connected = true;
    page.hear(page.sceneOf(here, true));
    expect(page.sent).toHaveLength(1);
    page.hear(page.sceneOf(there));
    page.hear(page.sceneOf(here, true)); // gone and back once more
    expect(page.sent).toHaveLength(2);
    expect(page.resolver.take()).toBeNull();
  });

  it.each<[FromServer, string | null]>([
    [{ kind: "refused", about: "change_scene", reason: "they overlap" }, "they overlap"],
    [{ kind: "failed", task: "solve", reason: "no memory" }, "no memory"],
    [{ kind: "refused", about: "chunk", reason: "disk full" }, null],
    [{ kind: "failed", task: "bases", reason: "no room" }, null],
  ])("fails for its own reasons only: %o", (message, failure) => {
    const page = new Page();
    page.resolver.begin({ box: there });
    page.hear(message);
    expect(page.resolver.take()?.failure ?? null).toBe(failure);
  });

  it("needs a server", () => {
    const page = new Page(false);
    page.resolver.begin({ box: there });
    expect(page.resolver.take()).toEqual({ failure: "There is no server to solve on." });
  });

  it("can be given up", () => {
    const page = new Page();
    page.resolver.begin({ box: there });
    page.resolver.cancel();
    page.hear(page.sceneOf(there, true));
    expect(page.resolver.take()).toBeNull();
  });
});
