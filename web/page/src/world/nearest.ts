import { Vector3 } from "three";
import type { NearestSurface } from "touchwarp";
import { Pose } from "../calibrate/pose.js";
import { type ContactSurface, SurfaceFoot } from "../calibrate/surface.js";

/** Nearest places of several surfaces that stand in the room as one. */
export class NearestOfAll implements NearestSurface {
  /** T_room_scene. */
  pose = new Pose();
  #foot = new SurfaceFoot();
  #place = new Vector3();
  #query = new Vector3();

  constructor(readonly surfaces: readonly ContactSurface[]) {}

  /** As `NearestSurface`: rows of points, room frame; a NaN gives NaN. */
  nearest(points: Float64Array, nearest: Float64Array, normals: Float64Array): void {
    const query = this.#query;
    for (let row = 0; row < points.length; row += 3) {
      query.fromArray(points, row);
      if (Number.isNaN(query.x)) {
        nearest.fill(Number.NaN, row, row + 3);
        normals.fill(Number.NaN, row, row + 3);
        continue;
      }
      this.pose.toProp(query, this.#place);
      let least = Number.POSITIVE_INFINITY;
      for (const surface of this.surfaces) {
        const foot = surface.nearest(this.#place, this.#foot);
        if (Math.abs(foot.distance) >= Math.abs(least)) continue;
        least = foot.distance;
        this.pose.toRoom(foot.point, query).toArray(nearest, row);
        query.copy(foot.gradient).applyQuaternion(this.pose.turn).toArray(normals, row);
      }
    }
  }
}
