import { Vector3 } from "three";
import type { NamedPoint } from "./contact.js";
import { type ContactSurface, SurfaceFoot } from "./surface.js";

/** Nobody reaches below this slope of the surface, or lower than this above the table, m. */
const LEAST_UPWARD = -0.3;
const LEAST_HEIGHT = 0.012;

/**
 * Whether a fingertip gets to a place of a prop that stands on a table.
 *
 * @param upward slope of the surface there; height above the prop's foot, m; radius of the fingertip
 */
export function isReachable(
  surface: ContactSurface,
  { point, normal }: NamedPoint,
  upward: number,
  height: number,
  radius: number,
): boolean {
  if (upward < LEAST_UPWARD || height < LEAST_HEIGHT) return false;
  // A place where the finger does not fit in, the inside of a handle say, is no place to touch.
  tip.copy(point).addScaledVector(normal, radius);
  return surface.nearest(tip, foot).distance >= 0.9 * radius;
}

/** How much another direction counts as another place, of the prop's own size. */
const TURN = 0.5;

/**
 * Places to touch one after another, each as far as may be from those before, in place and in
 * direction; the first is farthest from the middle. The prop stands with z up.
 */
export function placesToTouch(
  surface: ContactSurface,
  count: number,
  radius = 0.008,
): NamedPoint[] {
  const places = surface
    .sample(400)
    .filter((place) =>
      isReachable(surface, place, place.normal.z, place.point.z - surface.lowest.z, radius),
    );
  const middle = places
    .reduce((sum, { point }) => sum.add(point), new Vector3())
    .divideScalar(places.length);
  const out = ({ point }: NamedPoint) => Math.hypot(point.x - middle.x, point.y - middle.y);
  const apart = (one: NamedPoint, other: NamedPoint) =>
    one.point.distanceTo(other.point) / surface.reach + TURN * one.normal.distanceTo(other.normal);
  const chosen: NamedPoint[] = [];
  while (chosen.length < Math.min(count, places.length)) {
    const worth = (place: NamedPoint) =>
      chosen.length === 0 ? out(place) : Math.min(...chosen.map((other) => apart(place, other)));
    chosen.push(places.reduce((best, place) => (worth(place) > worth(best) ? place : best)));
  }
  return chosen;
}

const tip = new Vector3();
const foot = new SurfaceFoot();
