import { Matrix4, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { goalOf } from "../../src/desk/gizmo.js";
import {
  COLUMNS,
  packChunk,
  readPositions,
  readScenePose,
  unpackChunk,
  writeRow,
} from "../../src/live/rows.js";

const one = new Vector3(1, 1, 1);

function hand(turns: readonly Quaternion[]): Float32Array {
  const out = new Float32Array(400);
  for (let joint = 0; joint < 25; joint++) {
    const place = new Vector3(0.01 * joint, -0.02 * joint, 0.3);
    new Matrix4().compose(place, turns[joint % turns.length]!, one).toArray(out, 16 * joint);
  }
  return out;
}

// each of the four branches: a small turn, and half turns about each axis
const TURNS = [
  new Quaternion(0.1, 0.2, -0.1, 0.9).normalize(),
  new Quaternion(0.99, 0.05, 0.02, 0.01).normalize(),
  new Quaternion(0.05, 0.99, 0.02, -0.01).normalize(),
  new Quaternion(0.05, 0.02, 0.99, 0.01).normalize(),
];

const SCENE = new Matrix4().compose(new Vector3(0.1, 0.8, -0.4), TURNS[0]!, one).elements;

describe("a row of a recording", () => {
  const real = hand(TURNS);
  const displayed = hand(TURNS.slice(1));
  const row = new Float64Array(COLUMNS.length);
  writeRow(
    row,
    0,
    1234.5678901234567,
    1,
    0.5,
    2,
    real,
    displayed,
    new Float32Array(25).fill(0.5),
    SCENE,
  );
  const value = (name: string) => row[COLUMNS.indexOf(name)]!;

  it("has a named place for every number", () => {
    expect(new Set(COLUMNS).size).toBe(COLUMNS.length);
    expect(row.every(Number.isFinite)).toBe(true);
    expect(value("time_ms")).toBe(1234.5678901234567);
    expect(value("radius.pinky-finger-tip")).toBe(0.5);
  });

  it.each(["real", "displayed"])("holds %s positions and turns", (which) => {
    const turns = which === "real" ? TURNS : TURNS.slice(1);
    const names = COLUMNS.filter((n) => n.startsWith(`${which}.`) && n.endsWith(".x"));
    names.forEach((name, joint) => {
      const stem = name.slice(0, -2);
      expect(value(name)).toBeCloseTo(0.01 * joint, 6);
      const stored = new Quaternion(
        ...(["qx", "qy", "qz", "qw"].map((part) => value(`${stem}.${part}`)) as [
          number,
          number,
          number,
          number,
        ]),
      );
      expect(Math.abs(stored.dot(turns[joint % turns.length]!))).toBeCloseTo(1, 6);
    });
  });

  it("tells where the scene stood", () => {
    const [place, turn] = [new Vector3(), new Quaternion()];
    expect(readScenePose(row, 0, COLUMNS, place, turn)).toBe(true);
    expect(place.distanceTo(new Vector3(0.1, 0.8, -0.4))).toBeLessThan(1e-12);
    expect(Math.abs(turn.dot(TURNS[0]!))).toBeCloseTo(1, 12);
    const older = COLUMNS.filter((name) => !name.startsWith("scene."));
    expect(readScenePose(row, 0, older, place, turn)).toBe(false);
  });

  it("gives the positions back", () => {
    const out = new Float32Array(75);
    readPositions(row, 0, 1, out);
    expect(out[3 * 7 + 1]).toBeCloseTo(-0.14, 6);
  });

  it("keeps a lost joint as NaN", () => {
    const lost = real.slice().fill(Number.NaN, 0, 16);
    const other = new Float64Array(COLUMNS.length);
    writeRow(other, 0, 0, 0, 0, 0, lost, lost, new Float32Array(25), SCENE);
    expect(other[COLUMNS.indexOf("real.wrist.x")]).toBeNaN();
    expect(other[COLUMNS.indexOf("real.wrist.qw")]).toBeNaN();
  });
});

describe("a chunk", () => {
  it("comes back bit by bit", () => {
    const numbers = Float64Array.of(Math.PI, Number.NaN, -0, 5e-324);
    const header = { recording: "01234567", sequence: 3, rows: 2, warp: "wärp", notes: ["é"] };
    const back = unpackChunk(packChunk(header, numbers));
    expect(back.header).toEqual(header);
    expect(new BigUint64Array(back.numbers.slice().buffer)).toEqual(
      new BigUint64Array(numbers.buffer),
    );
  });
});

describe("goalOf", () => {
  it("is pivot + translation + R·S·(x − pivot), R = Rz·Ry·Rx", () => {
    const goal = new Matrix4().fromArray(
      goalOf([0, 0, -0.05], {
        scale: [1.2, 1, 0.5],
        rotation_deg: [0, 0, 30],
        translation: [0.02, 0, 0.001],
      }),
    );
    const base = new Vector3(0, 0, -0.05).applyMatrix4(goal);
    expect(base.toArray().map((v) => Number(v.toFixed(9)))).toEqual([0.02, 0, -0.049]);
    const side = new Vector3(0.1, 0, -0.05).applyMatrix4(goal).sub(base);
    expect(side.x).toBeCloseTo(0.12 * Math.cos(Math.PI / 6), 9);
    expect(side.y).toBeCloseTo(0.12 * Math.sin(Math.PI / 6), 9);
  });

  it("turns about x before y before z", () => {
    const placement = {
      scale: [1, 1, 1],
      rotation_deg: [90, 0, 90],
      translation: [0, 0, 0],
    } as const;
    const goal = new Matrix4().fromArray(goalOf([0, 0, 0], placement));
    const y = new Vector3(0, 1, 0).applyMatrix4(goal); // to z by the first turn, where it stays
    expect(y.z).toBeCloseTo(1, 9);
  });
});
