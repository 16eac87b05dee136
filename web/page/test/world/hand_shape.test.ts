import { Vector3 } from "three";
import { describe, expect, it } from "vitest";
import {
  Balls,
  CONE_VERTICES,
  CONES,
  skinFaces,
  tipVertices,
  VERTEX_COUNT,
  writeSkin,
} from "../../src/world/hand_shape.js";
import { pointingPoses, pointingRadii } from "../../src/world/pointing_hand.js";

function skinOf(poses = pointingPoses(), radii: Float32Array = pointingRadii) {
  const balls = new Balls();
  balls.place(poses, radii, 16, 12);
  const [positions, normals] = [
    new Float32Array(3 * VERTEX_COUNT),
    new Float32Array(3 * VERTEX_COUNT),
  ];
  writeSkin(balls, positions, normals);
  const at = (from: Float32Array, n: number) => new Vector3().fromArray(from, 3 * n);
  return {
    balls,
    point: (n: number) => at(positions, n),
    normal: (n: number) => at(normals, n),
  };
}

const centre = (balls: Balls, ball: number) => new Vector3().fromArray(balls.centres, 3 * ball);
const TIPS = [4, 9, 14, 19, 24];

describe("the drawn skin of a hand", () => {
  it("is the fingertip's own ball where a fingertip touches", () => {
    const skin = skinOf();
    tipVertices().forEach((vertices, finger) => {
      const tip = centre(skin.balls, TIPS[finger]!);
      for (const vertex of vertices) {
        expect(skin.point(vertex).distanceTo(tip)).toBeCloseTo(pointingRadii[TIPS[finger]!]!, 6);
      }
    });
  });

  it("touches every ball and goes into none: on round cones and on wedges", () => {
    const skin = skinOf();
    const faces = skinFaces();
    let deepest = 0;
    const touched = new Set<number>();
    for (let n = 0; n < VERTEX_COUNT; n++) {
      for (let ball = 0; ball < skin.balls.radii.length; ball++) {
        const away = skin.point(n).distanceTo(centre(skin.balls, ball)) - skin.balls.radii[ball]!;
        if (Math.abs(away) < 1e-6) touched.add(ball);
      }
    }
    // between two balls of a cone no triangle cuts deeper than its flatness
    for (let face = 0; face < faces.length; face += 3) {
      const corners = [0, 1, 2].map((k) => skin.point(faces[face + k]!));
      const middle = corners.reduce((sum, p) => sum.add(p), new Vector3()).divideScalar(3);
      const [a, b] = CONES[Math.floor(faces[face]! / CONE_VERTICES)] ?? [0, 0];
      for (const ball of a === b ? [] : [a, b]) {
        const depth = skin.balls.radii[ball]! - middle.distanceTo(centre(skin.balls, ball));
        deepest = Math.max(deepest, depth / skin.balls.radii[ball]!);
      }
    }
    expect(touched.size).toBe(28); // all but the wrist's own, whose place two flat ones take
    expect(deepest).toBeLessThan(0.06);
  });

  it("has its normals outward", () => {
    const skin = skinOf();
    const faces = skinFaces();
    let [outward, all] = [0, 0];
    for (let face = 0; face < faces.length; face += 3) {
      const [p, q, r] = [0, 1, 2].map((k) => skin.point(faces[face + k]!)) as [
        Vector3,
        Vector3,
        Vector3,
      ];
      const cross = q.clone().sub(p).cross(r.clone().sub(p));
      if (cross.lengthSq() < 1e-16) continue;
      all++;
      if (cross.dot(skin.normal(faces[face]!)) > 0) outward++;
    }
    expect(outward).toBe(all);
    expect(all).toBeGreaterThan(3000);
  });

  it("leaves out what is lost", () => {
    const poses = pointingPoses();
    poses.fill(Number.NaN, 16 * 9, 16 * 10);
    const skin = skinOf(poses);
    for (let n = 0; n < VERTEX_COUNT; n++) expect(skin.point(n).x).not.toBeNaN();
    expect(skin.point(tipVertices()[1]![0]!).length()).toBe(0);
  });
});
