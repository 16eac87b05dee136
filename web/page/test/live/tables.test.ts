import type { AffineBases, Matrix, openWarp, Warp } from "touchwarp";
import { beforeEach, describe, expect, it } from "vitest";
import type { SceneState, WarpFile } from "../../src/live/messages.js";
import { columns, Tables } from "../../src/live/tables.js";

Object.assign(globalThis, { document: { baseURI: "http://localhost/" } });

/** A table that arrives when a test says so. */
class Arriving {
  levelsLoaded = 0;
  readonly levelCount = 2;
  constructor(
    readonly name: string,
    readonly levelErrorsMm: readonly number[] = [3, 0.01],
  ) {}
  get addedErrorMm(): number {
    return this.levelErrorsMm[this.levelsLoaded - 1]!;
  }
}

interface Request {
  readonly url: string;
  come(table: object): void;
  level(): void;
  finish(): void;
  fail(): void;
}

let requests: Request[] = [];
let tables: Tables;

/** Stands in for `openWarp`: what was asked for, to be answered by hand. */
const open = ((source: URL, { onLevel }: { onLevel: (n: number, of: number) => void }) =>
  new Promise((resolve, reject) => {
    let done = () => {};
    let broken = (_: Error) => {};
    const complete = new Promise<void>((end, fail) => {
      done = end;
      broken = fail;
    });
    complete.catch(() => {});
    requests.push({
      url: source.pathname,
      come: (table) => resolve({ warp: table, complete }),
      level: () => onLevel(0, 0),
      finish: () => done(),
      fail: () => {
        reject(new Error("broke off"));
        broken(new Error("broke off"));
      },
    });
  })) as unknown as typeof openWarp;

beforeEach(() => {
  requests = [];
  tables = new Tables(open);
});

const settle = () => new Promise((resolve) => setTimeout(resolve));

function file(identity: string, estimate = 0.1): WarpFile {
  return {
    identity,
    url: `./${identity}`,
    size: 1,
    estimated_error_max_mm: estimate,
    storage_error_mm: 0.01,
  };
}

function matrix(shift: number) {
  return [
    [1, 0, 0, shift],
    [0, 1, 0, 0],
    [0, 0, 1, 0],
    [0, 0, 0, 1],
  ] as const;
}

function state(shift: number, change: Partial<SceneState>): SceneState {
  return {
    props: [{ name: "mug", goal: matrix(shift), pose: {}, surface: "./mug" }],
    warp: null,
    warp_current: false,
    bases: null,
    ...change,
  } as unknown as SceneState;
}

/** A solved warp as it is looked up. */
function warpNamed(name: string): Warp {
  const warp = new Arriving(name) as unknown as { displayed: () => void; levelsLoaded: number };
  warp.displayed = () => {};
  warp.levelsLoaded = 2;
  return warp as unknown as Warp;
}

function basesNamed(bound = 0.5): AffineBases {
  const instant = {
    levelsLoaded: 2,
    levelCount: 2,
    addedErrorMm: 0,
    errorBoundMm: bound,
    goals: new Map<string, Float64Array>(),
    setGoal(name: string, goal: Float64Array) {
      this.goals.set(name, goal);
    },
  };
  return { warp: () => instant } as unknown as AffineBases;
}

describe("the warp in use", () => {
  it("is never that of a scene which is not shown any more", async () => {
    tables.update(state(0, { warp: file("old"), warp_current: true }));
    const old = warpNamed("old");
    requests[0]!.come(old);
    requests[0]!.finish();
    await settle();
    expect([tables.current, tables.exact, tables.file?.identity]).toEqual([old, true, "old"]);
    tables.update(state(0.01, { warp: file("old") }));
    expect([tables.current, tables.file]).toEqual([null, null]);
    // solved, but not here yet: until then hands go through nothing
    tables.update(state(0.01, { warp: file("new"), warp_current: true }));
    expect(requests.map(({ url }) => url)).toEqual(["/old", "/new"]);
    expect([tables.current, tables.exact]).toEqual([null, false]);
    const fresh = warpNamed("new");
    requests[1]!.come(fresh);
    await settle();
    expect([tables.current, tables.exact]).toEqual([fresh, true]);
  });

  it("stays where only λ has changed, until there is a better one", async () => {
    tables.update(state(0, { warp: file("old"), warp_current: true }));
    const old = warpNamed("old");
    requests[0]!.come(old);
    await settle();
    tables.update(state(0, { warp: file("old") }));
    expect([tables.current, tables.exact]).toEqual([old, false]);
    tables.update(state(0, { warp: file("old"), bases: file("bases") }));
    requests[1]!.come(basesNamed());
    await settle();
    expect(tables.file?.identity).toBe("bases");
  });

  it("is instant while an object is moved, and solved again once that is finer", async () => {
    tables.update(state(0, { warp: file("old"), warp_current: true, bases: file("bases") }));
    requests[0]!.come(warpNamed("old"));
    requests[1]!.come(basesNamed(0.5));
    await settle();
    expect([tables.file?.identity, tables.exact, tables.instant]).toEqual(["old", true, true]);
    tables.setGoal("mug", columns(matrix(0.01)));
    expect([tables.file?.identity, tables.exact, tables.errorMm]).toEqual(["bases", false, 0.5]);
    tables.update(state(0.01, { warp: file("new"), warp_current: true, bases: file("bases") }));
    const fresh = warpNamed("new") as unknown as { levelsLoaded: number };
    fresh.levelsLoaded = 1; // 3 mm off
    requests[2]!.come(fresh);
    await settle();
    expect([tables.file?.identity, tables.exact]).toEqual(["bases", false]);
    fresh.levelsLoaded = 2;
    requests[2]!.level();
    expect([tables.file?.identity, tables.exact]).toEqual(["new", true]);
    expect(tables.errorMm).toBeCloseTo(0.11);
  });

  it("is used from its first level on where there is none", async () => {
    tables.update(state(0, { warp: file("only"), warp_current: true }));
    const warp = warpNamed("only") as unknown as { levelsLoaded: number };
    warp.levelsLoaded = 1;
    requests[0]!.come(warp);
    await settle();
    expect([tables.current, tables.errorMm]).toEqual([warp, 3.1]);
    warp.levelsLoaded = 2;
    requests[0]!.level();
    expect(tables.errorMm).toBeCloseTo(0.11);
  });

  it("comes back with a scene that comes back", async () => {
    tables.update(state(0, { warp: file("a"), warp_current: true }));
    const first = warpNamed("a");
    requests[0]!.come(first);
    await settle();
    tables.update(state(0.01, { warp: file("b"), warp_current: true }));
    tables.update(state(0, { warp: file("a"), warp_current: true }));
    expect([tables.current, tables.exact]).toEqual([first, true]);
    requests[1]!.come(warpNamed("b")); // late, of a scene that is gone
    await settle();
    expect([tables.current, tables.exact]).toEqual([first, true]);
  });

  it("is asked for again after it broke off", async () => {
    const now = state(0, { warp: file("a"), warp_current: true, bases: file("bases") });
    tables.update(now);
    for (const request of requests) request.fail();
    await settle();
    expect([tables.current, tables.problem]).toEqual([null, "broke off"]);
    tables.update(now);
    expect(requests.map(({ url }) => url)).toEqual(["/a", "/bases", "/a", "/bases"]);
    requests[2]!.come(warpNamed("a"));
    requests[2]!.fail(); // in the middle this time
    await settle();
    expect(tables.current).toBeNull();
    tables.update(now);
    requests.at(-1)!.come(warpNamed("a"));
    requests.at(-1)!.finish();
    await settle();
    expect([tables.exact, tables.problem]).toEqual([true, null]);
  });

  it("is not the solved one again by a state from before the move", async () => {
    const now = state(0, { warp: file("a"), warp_current: true, bases: file("bases") });
    tables.update(now);
    requests[0]!.come(warpNamed("solved"));
    requests[1]!.come(basesNamed());
    for (const request of requests) request.finish();
    await settle();
    expect(tables.exact).toBe(true);
    tables.setGoal("mug", columns(matrix(0.02)));
    tables.update({ ...now, certificate: null }); // the check ended while the object was held
    expect([tables.exact, tables.shows(now.props[0]!)]).toEqual([false, false]);
    const moved = state(0.02, { warp: file("a"), warp_current: false, bases: file("bases") });
    tables.update(moved);
    expect([tables.exact, tables.shows(moved.props[0]!)]).toEqual([false, true]);
    tables.update(state(0.02, { warp: file("b"), warp_current: true, bases: file("bases") }));
    requests[2]!.come(warpNamed("solved anew"));
    requests[2]!.finish();
    await settle();
    expect(tables.exact).toBe(true);
  });

  it("stays where it was moved to when a state tells an earlier move", async () => {
    const at = (shift: number) => state(shift, { bases: file("bases") });
    tables.update(at(0));
    const bases = basesNamed();
    requests[0]!.come(bases);
    await settle();
    const shown = () =>
      (bases.warp() as unknown as { goals: Map<string, Matrix> }).goals.get("mug");
    tables.setGoal("mug", columns(matrix(0.01))); // let go of, and taken up again
    tables.setGoal("mug", columns(matrix(0.03)));
    const { generation } = tables;
    tables.update(at(0.01));
    expect([tables.goal("mug")![12], shown()![12], tables.moved]).toEqual([0.03, 0.03, true]);
    expect(tables.generation).toBe(generation);
    tables.update(at(0.03));
    expect([tables.goal("mug")![12], tables.moved]).toEqual([0.03, false]);
    tables.update(at(0.05)); // somebody else's
    expect([tables.goal("mug")![12], shown()![12]]).toEqual([0.05, 0.05]);
  });

  it("follows what is told of other props while one is moved", () => {
    const both = (mug: number, cup: number) =>
      state(0, {
        props: [
          { name: "mug", goal: matrix(mug), pose: {}, surface: "./mug" },
          { name: "cup", goal: matrix(cup), pose: {}, surface: "./cup" },
        ],
      } as unknown as Partial<SceneState>);
    tables.update(both(0, 0));
    tables.setGoal("mug", columns(matrix(0.03)));
    tables.update(both(0.01, 0.02));
    expect([tables.goal("mug")![12], tables.goal("cup")![12]]).toEqual([0.03, 0.02]);
    tables.restore(both(0.04, 0.02)); // the server had the move, and has another since
    expect([tables.goal("mug")![12], tables.moved]).toEqual([0.04, false]);
  });

  it("tells no problem of a file that is no longer wanted", async () => {
    tables.update(state(0, { warp: file("a"), warp_current: true }));
    tables.update(state(0.01, { warp: file("b"), warp_current: true }));
    requests[0]!.fail();
    await settle();
    expect(tables.problem).toBeNull();
    requests[1]!.fail();
    await settle();
    expect(tables.problem).toBe("broke off");
    tables.update(state(0.02, { warp: null, warp_current: false })); // as of a server started anew
    expect(tables.problem).toBeNull();
  });

  it("is the solved one again when a move was refused", async () => {
    const now = state(0, { warp: file("a"), warp_current: true, bases: file("bases") });
    tables.update(now);
    requests[0]!.come(warpNamed("a"));
    requests[1]!.come(basesNamed());
    await settle();
    tables.setGoal("mug", new Float64Array(16).fill(2));
    expect(tables.exact).toBe(false);
    tables.restore(now);
    expect([tables.exact, tables.goal("mug")![12]]).toEqual([true, 0]);
  });

  it("counts what is displayed anew: a move, not the solve of what was moved to", () => {
    const before = state(0, { warp: file("a"), warp_current: true });
    tables.update(before);
    const { generation } = tables;
    const goal = new Float64Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.01, 0, 0, 1]);
    tables.setGoal("mug", goal);
    expect(tables.generation).toBe(generation + 1);
    tables.update(state(0.01, { warp: file("a") })); // the server has heard of it
    tables.update(state(0.01, { warp: file("b"), warp_current: true }));
    expect(tables.generation).toBe(generation + 1);
    tables.update(state(0.02, { warp: file("b") })); // somebody else has moved it
    expect(tables.generation).toBe(generation + 2);
    const stands = { name: "mug", goal: matrix(0.02), pose: { x: 1 }, surface: "./mug" };
    tables.update(state(0, { props: [stands] } as unknown as Partial<SceneState>));
    expect(tables.generation).toBe(generation + 3);
  });
});
