import { Vector3 } from "three";
import { expect, test } from "vitest";
import { SurfaceFoot } from "../../src/calibrate/surface.js";
import { FollowedPoints } from "../../src/world/nearest.js";
import { seeded } from "../calibrate/rubbing.js";
import { ball } from "./ball.js";

const surfaces = [ball(new Vector3(), 0.04), ball(new Vector3(0.1, 0.02, 0), 0.03)];

/** The nearest place, every triangle being sought. */
function sought(point: Vector3): SurfaceFoot {
  const feet = surfaces.map((surface) => surface.nearest(point, new SurfaceFoot()));
  return feet.reduce((one, other) =>
    Math.abs(other.distance) < Math.abs(one.distance) ? other : one,
  );
}

/** Points that move as fingertips do, with a leap now and then; by up to `step` m a frame. */
function* walk(step: number): Generator<Vector3> {
  const random = seeded(7);
  const point = new Vector3(0.05, 0, 0);
  for (let frame = 0; frame < 2000; frame++) {
    const reach = frame % 97 === 0 ? 0.1 : step;
    for (const axis of [0, 1, 2]) {
      const moved = point.getComponent(axis) + reach * (2 * random() - 1);
      point.setComponent(axis, Math.max(-0.15, Math.min(0.2, moved)));
    }
    yield point;
  }
}

test.each([0.0005, 0.004, 0.03])("a followed point has the nearest place, %d m a frame", (step) => {
  const followed = new FollowedPoints(surfaces, 1);
  for (const point of walk(step)) {
    const [found, exact] = [followed.find(0, point), sought(point)];
    expect(Math.abs(found.distance - exact.distance)).toBeLessThan(1e-12);
    expect(found.point.distanceTo(exact.point)).toBeLessThan(1e-9);
  }
});

test("a point within range has its nearest place, one beyond is told to be beyond", () => {
  const range = 0.03;
  const followed = new FollowedPoints(surfaces, 1);
  let beyond = 0;
  for (const point of walk(0.004)) {
    const [found, exact] = [followed.find(0, point, range), sought(point)];
    if (Math.abs(exact.distance) <= range) expect(found.distance).toBeCloseTo(exact.distance, 12);
    else {
      beyond++;
      expect(found.distance).toBeGreaterThan(range);
      expect(found.distance).toBeLessThan(exact.distance + 1e-12);
      expect(point.distanceTo(found.point)).toBeGreaterThan(exact.distance - 1e-12);
    }
  }
  expect(beyond).toBeGreaterThan(200);
});

test("a bound below the distance finds nothing, or what is farther than it", () => {
  const foot = new SurfaceFoot();
  expect(surfaces[0]!.nearest(new Vector3(0.09, 0, 0), foot, 0.02)).toBeNull();
});
