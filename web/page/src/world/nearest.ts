import { Vector3 } from "three";
import type { NearestSurface } from "touchwarp";
import { Pose } from "../calibrate/pose.js";
import { type ContactSurface, SurfaceFoot } from "../calibrate/surface.js";

/** What rounding may add to a distance that bounds another. */
const ROUNDED = 1 + 1e-6;

/** Nearest places of several surfaces, for points that move a little from one frame to the next. */
export class FollowedPoints {
  #feet: SurfaceFoot[];
  /** Where each point was when it was looked up, NaN before, and which one is looked up now. */
  #before: Vector3[];
  #found = new SurfaceFoot();

  /** @param count how many points are followed. */
  constructor(
    readonly surfaces: readonly ContactSurface[],
    count: number,
  ) {
    this.#feet = Array.from({ length: count }, () => new SurfaceFoot());
    this.#before = this.#feet.map(() => new Vector3(Number.NaN, Number.NaN, Number.NaN));
  }

  /**
   * The nearest place to point n, which is at `point`, in the surfaces' frame.
   *
   * Its last place, being on a surface, is no nearer than the nearest: that bounds the search. A point
   * that cannot have come nearer than `range` is not looked up: some place is given, farther away.
   */
  find(n: number, point: Vector3, range = Number.POSITIVE_INFINITY): SurfaceFoot {
    const foot = this.#feet[n]!;
    const before = this.#before[n]!;
    const sign = foot.distance < 0 ? -1 : 1;
    const least = Math.abs(foot.distance) - point.distanceTo(before);
    if (least > range) {
      // it has not come through a surface on its way
      foot.gradient.subVectors(point, foot.point);
      const away = foot.gradient.length();
      foot.gradient.multiplyScalar(sign / away);
      foot.distance = sign * least;
      before.copy(point);
      return foot;
    }
    const known = Number.isNaN(before.x) ? Number.POSITIVE_INFINITY : point.distanceTo(foot.point);
    if (!this.#search(point, ROUNDED * known + 1e-9, foot)) {
      this.#search(point, Number.POSITIVE_INFINITY, foot);
    }
    before.copy(point);
    return foot;
  }

  #search(point: Vector3, within: number, out: SurfaceFoot): boolean {
    let least = within;
    let any = false;
    for (const surface of this.surfaces) {
      const found = surface.nearest(point, this.#found, least);
      if (!found || Math.abs(found.distance) >= least) continue;
      least = Math.abs(found.distance);
      out.copy(found);
      any = true;
    }
    return any;
  }
}

/** Surfaces that stand in the room as one. */
export class PlacedSurfaces {
  /** T_room_scene. */
  pose = new Pose();

  constructor(readonly surfaces: readonly ContactSurface[]) {}
}

/** Nearest places of placed surfaces for the rows of one array, which move from frame to frame. */
export class FollowedRows implements NearestSurface {
  /** m: of what is farther, no more is told than that. */
  range = Number.POSITIVE_INFINITY;
  #points: FollowedPoints;
  #place = new Vector3();

  constructor(
    readonly placed: PlacedSurfaces,
    rows: number,
  ) {
    this.#points = new FollowedPoints(placed.surfaces, rows);
  }

  /** As `NearestSurface`: rows of points, room frame; a NaN gives NaN. */
  nearest(points: Float64Array, nearest: Float64Array, normals: Float64Array): void {
    const { pose, surfaces } = this.placed;
    const place = this.#place;
    for (let row = 0; row < points.length; row += 3) {
      if (surfaces.length === 0 || Number.isNaN(points[row]!)) {
        nearest.fill(Number.NaN, row, row + 3);
        normals.fill(Number.NaN, row, row + 3);
        continue;
      }
      pose.toProp(place.fromArray(points, row), place);
      const foot = this.#points.find(row / 3, place, this.range);
      pose.toRoom(foot.point, place).toArray(nearest, row);
      place.copy(foot.gradient).applyQuaternion(pose.turn).toArray(normals, row);
    }
  }
}
