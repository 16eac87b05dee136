import { DoubleSide, Group, Mesh, MeshBasicMaterial, MeshStandardMaterial, Vector3 } from "three";
import type { NearestSurface } from "touchwarp";
import { Pose } from "../calibrate/pose.js";
import { ContactSurface, SurfaceFoot } from "../calibrate/surface.js";
import { goalAt, type SurfaceGoal } from "../calibrate/symmetry.js";
import type { PropState } from "../live/messages.js";
import { fetchSurface, geometryOf } from "../world/surface.js";

/** A prop in the headset: its surface to calibrate by, its ghost and its virtual object. */
export class PropModel implements SurfaceGoal {
  /** Both in the scene frame. */
  readonly ghost = new Group();
  readonly virtualObject: Mesh;
  /** The virtual object's surface, for the gap of displayed skin. */
  readonly virtualSurface: ContactSurface;

  private constructor(
    readonly state: PropState,
    readonly surface: ContactSurface,
    readonly virtual: Float32Array,
    faces: Uint32Array,
  ) {
    const shape = geometryOf(surface.positions, faces);
    const glass = { color: 0x3ad6c4, transparent: true, opacity: 0.22, depthWrite: false };
    const lines = { color: 0x3ad6c4, wireframe: true, transparent: true, opacity: 0.12 };
    this.ghost.add(
      new Mesh(shape, new MeshStandardMaterial({ ...glass, side: DoubleSide })),
      new Mesh(shape, new MeshBasicMaterial(lines)),
    );
    const china = { color: 0xf3ede2, roughness: 0.35, metalness: 0.02, side: DoubleSide };
    this.virtualObject = new Mesh(geometryOf(virtual, faces), new MeshStandardMaterial(china));
    this.virtualSurface = new ContactSurface(virtual, faces);
  }

  static async fetch(state: PropState): Promise<PropModel> {
    const { prop, virtual, faces } = await fetchSurface(state.surface);
    return new PropModel(state, new ContactSurface(prop, faces), virtual, faces);
  }

  dispose(): void {
    this.ghost.removeFromParent();
    this.virtualObject.removeFromParent();
  }
}

/** The prop nearest to a point, and what the goal says there; everything in the room. */
export interface Felt {
  readonly prop: PropModel;
  /** Nearest point of the prop, and its unit direction outward. */
  readonly point: Vector3;
  readonly outward: Vector3;
  /** Where that point shall appear. */
  readonly goal: Vector3;
  readonly distance: number;
}

/** All props where they stand in the room, for lookups of nearest places. */
export class PlacedProps implements NearestSurface {
  /** T_room_scene. */
  pose = new Pose();
  private readonly foot = new SurfaceFoot();
  private readonly place = new Vector3();

  constructor(readonly props: readonly PropModel[]) {}

  /** The nearest place of any prop to a point of the room. */
  felt(point: Vector3): Felt {
    this.pose.toProp(point, this.place);
    let nearest = this.props[0]!;
    let least = Number.POSITIVE_INFINITY;
    for (const prop of this.props) {
      const distance = prop.surface.nearest(this.place, this.foot).distance;
      if (Math.abs(distance) < Math.abs(least)) [nearest, least] = [prop, distance];
    }
    nearest.surface.nearest(this.place, this.foot);
    return {
      prop: nearest,
      point: this.pose.toRoom(this.foot.point),
      outward: this.foot.gradient.clone().applyQuaternion(this.pose.turn),
      goal: this.pose.toRoom(goalAt(nearest, this.foot, new Vector3())),
      distance: least,
    };
  }

  /** Signed distance of a point of the room from the nearest virtual surface, and the way out. */
  seen(point: Vector3, outward: Vector3): number {
    this.pose.toProp(point, this.place);
    let least = Number.POSITIVE_INFINITY;
    for (const { virtualSurface } of this.props) {
      const { distance, gradient } = virtualSurface.nearest(this.place, this.foot);
      if (Math.abs(distance) < Math.abs(least)) {
        least = distance;
        outward.copy(gradient).applyQuaternion(this.pose.turn);
      }
    }
    return least;
  }

  nearest(points: Float64Array, nearest: Float64Array, normals: Float64Array): void {
    for (let row = 0; row < points.length; row += 3) {
      query.fromArray(points, row);
      if (Number.isNaN(query.x)) {
        nearest.fill(Number.NaN, row, row + 3);
        normals.fill(Number.NaN, row, row + 3);
        continue;
      }
      this.pose.toProp(query, this.place);
      let least = Number.POSITIVE_INFINITY;
      for (const { surface } of this.props) {
        const foot = surface.nearest(this.place, this.foot);
        if (Math.abs(foot.distance) >= Math.abs(least)) continue;
        least = foot.distance;
        this.pose.toRoom(foot.point, query).toArray(nearest, row);
        query.copy(foot.gradient).applyQuaternion(this.pose.turn).toArray(normals, row);
      }
    }
  }
}

const query = new Vector3();
