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

/** The server tells a scene, and that it holds the last change. */
const arrive = (revision: number, number: number) => {
  hear(state(revision, true));
  hear({ kind: "changed", number, revision });
};

describe("changes of the scene", () => {
  it("are sent at once, and once", () => {
    changes.ask({ mismatch_weight: 3 });
    arrive(1, 1);
    hear(state(2, true));
    expect(sent).toEqual([{ kind: "change_scene", number: 1, mismatch_weight: 3 }]);
  });

  it("are pending until the server tells a scene that holds the last of them", () => {
    hear(state(0, false));
    changes.ask({ goals: { mug: placed(1) } });
    changes.ask({ goals: { mug: placed(2) } });
    arrive(1, 1); // of the first
    expect(changes.pending).toBe(true);
    hear({ kind: "changed", number: 2, revision: 2 }); // taken up, and its scene is on its way
    expect(changes.pending).toBe(true);
    hear(state(2, true));
    expect(changes.pending).toBe(false);
    changes.ask({ goals: { mug: placed(2) } }); // which changes nothing
    expect(changes.pending).toBe(true);
    hear({ kind: "changed", number: 3, revision: 2 });
    expect(changes.pending).toBe(false);
  });

  it("are sent again if only those before them arrived as the connection closed", () => {
    hear(state(0, false));
    changes.ask({ goals: { mug: placed(1) } });
    changes.ask({ mismatch_weight: 3 });
    arrive(1, 1);
    tellStatus(false);
    tellStatus(true);
    hear(state(1, true));
    expect(sent.at(-1)).toEqual({
      kind: "change_scene",
      number: 3,
      goals: { mug: placed(1) },
      mismatch_weight: 3,
    });
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
    const all = { goals: { mug: placed(2) }, mismatch_weight: 5 };
    expect(sent).toEqual([{ kind: "change_scene", number: 4, ...all }]);
  });

  it("that were not saved are sent again to a server that has begun anew", () => {
    changes.ask({ goals: { mug: placed(1) } });
    arrive(1, 1);
    changes.ask({ goals: { cup: placed(2) } });
    arrive(2, 2);
    hear(state(0, false));
    expect(sent.at(-1)).toEqual({
      kind: "change_scene",
      number: 3,
      goals: { mug: placed(1), cup: placed(2) },
    });
  });

  it("that were saved, or refused, are not", () => {
    changes.ask({ goals: { mug: placed(1) } });
    arrive(1, 1);
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
    const again = (number: number) => ({ kind: "change_scene", number, mismatch_weight: 3 });
    expect(sent).toEqual([1, 2].map(again));
    arrive(1, 2);
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
    const again = (number: number) => ({ kind: "change_scene", number, mismatch_weight: 3 });
    expect(sent).toEqual([1, 2].map(again));
  });

  it("are saved once the server has them all", () => {
    hear(state(0, false));
    changes.ask({ mismatch_weight: 3 });
    arrive(1, 1);
    open = false;
    tellStatus(false);
    changes.ask({ mismatch_weight: 4 });
    changes.save(); // while it is gone
    open = true;
    tellStatus(true);
    changes.save(); // it is back, but has not told its scene
    hear(state(0, false));
    expect(sent.slice(1)).toEqual([
      { kind: "change_scene", number: 3, mismatch_weight: 4 },
      { kind: "save_scene" },
    ]);
    hear(state(1, true));
    hear(state(1, false));
    expect(sent).toHaveLength(3);
    changes.save();
    expect(sent).toHaveLength(4);
  });
});
