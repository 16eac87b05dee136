import { Triangle, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { Triangles } from "../../src/calibrate/triangles.js";
import { seeded } from "./rubbing.js";

const random = seeded(3);
const anywhere = (reach: number) =>
  new Vector3(random() - 0.5, random() - 0.5, random() - 0.5).multiplyScalar(reach);

/** Triangles strewn about, small and long ones, and some without area. */
function strewn(count: number) {
  const corners: Vector3[] = [];
  for (let k = 0; k < count; k++) {
    const middle = anywhere(0.2);
    const size = 0.04 * random() ** 2;
    const [a, b] = [anywhere(size).add(middle), anywhere(size).add(middle)];
    const c = k % 50 === 0 ? a.clone() : anywhere(size).add(middle);
    corners.push(a, b, c);
  }
  const positions = Float32Array.from(corners.flatMap((corner) => corner.toArray()));
  const faces = Uint32Array.from(corners, (_, k) => k);
  const corner = (k: number) => new Vector3().fromArray(positions, 3 * k);
  const each = Array.from(
    { length: count },
    (_, face) => new Triangle(corner(3 * face), corner(3 * face + 1), corner(3 * face + 2)),
  );
  return { triangles: new Triangles(positions, faces), each };
}

const { triangles, each } = strewn(1500);

/** The least distance, every triangle being asked, by three's own method. */
function least(point: Vector3): number {
  const nearest = new Vector3();
  let distance = Number.POSITIVE_INFINITY;
  for (const triangle of each) {
    const away = point.distanceTo(triangle.closestPointToPoint(point, nearest));
    if (away < distance) distance = away; // not where there is no area: NaN
  }
  return distance;
}

describe("the nearest of many triangles", () => {
  it("is as near as any, and where it is told to be", () => {
    const told = new Vector3();
    for (let k = 0; k < 500; k++) {
      const point = anywhere(0.3);
      expect(triangles.find(point.x, point.y, point.z, Number.POSITIVE_INFINITY)).toBe(true);
      const { face, s, t, x, y, z, squared } = triangles;
      expect(Math.abs(Math.sqrt(squared) - least(point))).toBeLessThan(1e-12);
      expect(Math.abs(point.distanceTo(told.set(x, y, z)) - Math.sqrt(squared))).toBeLessThan(
        1e-12,
      );
      const { a, b, c } = each[face]!;
      const weighted = a
        .clone()
        .multiplyScalar(1 - s - t)
        .addScaledVector(b, s)
        .addScaledVector(c, t);
      expect(weighted.distanceTo(told)).toBeLessThan(1e-12);
      expect(Math.min(s, t, 1 - s - t)).toBeGreaterThan(-1e-12);
    }
  });

  it("is not the one with the nearest corner: that would be found to be farther", () => {
    let farther = 0;
    for (let k = 0; k < 100; k++) {
      const point = anywhere(0.3);
      const corners = each.flatMap(({ a, b, c }) => [a, b, c]);
      const toCorner = Math.min(...corners.map((corner) => corner.distanceTo(point)));
      if (toCorner > least(point) + 1e-6) farther++;
    }
    expect(farther).toBeGreaterThan(10);
  });

  it("is not sought beyond a bound", () => {
    for (let k = 0; k < 200; k++) {
      const point = anywhere(0.3);
      const away = least(point);
      expect(triangles.find(point.x, point.y, point.z, away * (1 - 1e-9))).toBe(false);
      expect(triangles.find(point.x, point.y, point.z, away * (1 + 1e-9) + 1e-12)).toBe(true);
    }
  });
});
