import { beforeEach, describe, expect, it } from "vitest";
import { Changes } from "../../src/live/changes.js";
import type { Connection } from "../../src/live/connection.js";
import type { ChangeScene, FromServer, Placement, SaveScene } from "../../src/live/messages.js";

const placed = (x: number): Placement => ({
  scale: [1, 1, 1],
  rotation_deg: [0, 0, 0],
  translation: [x, 0, 0],
});

let open: boolean;
let sent: (ChangeScene | SaveScene)[];
let hear: (message: FromServer) => void;
let tellStatus: (open: boolean) => void;
let changes: Changes;

beforeEach(() => {
  [open, sent] = [true, []];
  changes = new Changes({
    send(message: ChangeScene | SaveScene) {
      if (open) sent.push(message);
      return open;
    },
    listen(listener: (message: FromServer) => void) {
      hear = listener;
      return () => {};
    },
    listenStatus(listener: (open: boolean) => void) {
      tellStatus = listener;
      return () => {};
    },
  } as unknown as Connection);
});

const state = (revision: number, unsaved: boolean) =>
  ({ kind: "state", revision, unsaved }) as unknown as FromServer;

describe("changes of the scene", () => {
  it("are sent at once, and once", () => {
    changes.ask({ mismatch_weight: 3 });
    hear(state(1, true));
    hear(state(2, true));
    expect(sent).toEqual([{ kind: "change_scene", mismatch_weight: 3 }]);
  });

  it("that are made while the server is gone are sent when it is back, the last of each", () => {
    hear(state(4, false));
    open = false;
    changes.ask({ goals: { mug: placed(1) } });
    changes.ask({ goals: { mug: placed(2) } });
    changes.ask({ mismatch_weight: 5 });
    expect(sent).toEqual([]);
    open = true;
    hear(state(4, false));
    expect(sent).toEqual([{ kind: "change_scene", goals: { mug: placed(2) }, mismatch_weight: 5 }]);
  });

  it("that were not saved are sent again to a server that has begun anew", () => {
    changes.ask({ goals: { mug: placed(1) } });
    hear(state(1, true));
    changes.ask({ goals: { cup: placed(2) } });
    hear(state(2, true));
    hear(state(0, false));
    expect(sent.at(-1)).toEqual({
      kind: "change_scene",
      goals: { mug: placed(1), cup: placed(2) },
    });
  });

  it("that were saved, or refused, are not", () => {
    changes.ask({ goals: { mug: placed(1) } });
    hear(state(1, true));
    hear(state(1, false)); // saved
    hear(state(0, false));
    changes.ask({ goals: { mug: placed(9) } });
    hear({ kind: "refused", about: "change_scene", reason: "too far" });
    hear(state(1, false));
    hear(state(0, false));
    expect(sent).toHaveLength(2);
  });

  it("that got lost as the connection closed are sent again", () => {
    hear(state(0, false));
    changes.ask({ mismatch_weight: 3 });
    tellStatus(false);
    tellStatus(true);
    hear(state(0, false));
    expect(sent).toEqual(Array(2).fill({ kind: "change_scene", mismatch_weight: 3 }));
    hear(state(1, true)); // they have arrived
    tellStatus(false);
    tellStatus(true);
    hear(state(1, true));
    expect(sent).toHaveLength(2);
  });

  it("that were on their way while another scene was told are not forgotten", () => {
    hear(state(3, false));
    changes.ask({ mismatch_weight: 3 });
    hear(state(3, false)); // told before it arrived
    tellStatus(false);
    tellStatus(true);
    hear(state(3, false));
    expect(sent).toEqual(Array(2).fill({ kind: "change_scene", mismatch_weight: 3 }));
  });

  it("are saved once the server has them all", () => {
    hear(state(0, false));
    changes.ask({ mismatch_weight: 3 });
    hear(state(1, true));
    open = false;
    tellStatus(false);
    changes.ask({ mismatch_weight: 4 });
    changes.save(); // while it is gone
    open = true;
    tellStatus(true);
    changes.save(); // it is back, but has not told its scene
    hear(state(0, false));
    expect(sent.slice(1)).toEqual([
      { kind: "change_scene", mismatch_weight: 4 },
      { kind: "save_scene" },
    ]);
    hear(state(1, true));
    hear(state(1, false));
    expect(sent).toHaveLength(3);
    changes.save();
    expect(sent).toHaveLength(4);
  });
});
