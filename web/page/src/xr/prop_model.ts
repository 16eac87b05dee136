import {
  DoubleSide,
  Group,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  Vector3,
} from "three";
import { ContactSurface, SurfaceFoot } from "../calibrate/surface.js";
import { goalAt, type SurfaceGoal } from "../calibrate/symmetry.js";
import type { PropState } from "../live/messages.js";
import { FollowedPoints, PlacedSurfaces } from "../world/nearest.js";
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
    this.virtualObject.castShadow = this.virtualObject.receiveShadow = true;
    this.virtualSurface = new ContactSurface(virtual, faces);
  }

  /** @param goal where the prop appears now, if that is affine: it may have been dragged. */
  static async fetch(state: PropState, goal?: Float64Array): Promise<PropModel> {
    const { prop, virtual, faces } = await fetchSurface(state.surface);
    const shown = goal === undefined ? virtual : moved(prop, goal);
    return new PropModel(state, new ContactSurface(prop, faces), shown, faces);
  }

  dispose(): void {
    this.ghost.removeFromParent();
    this.virtualObject.removeFromParent();
  }
}

/** Points under an affine goal; a surface that is sent may be that of an earlier one. */
function moved(points: Float32Array, goal: Float64Array): Float32Array {
  const matrix = new Matrix4().fromArray(goal);
  const out = new Float32Array(points.length);
  const point = new Vector3();
  for (let at = 0; at < points.length; at += 3) {
    point.fromArray(points, at).applyMatrix4(matrix).toArray(out, at);
  }
  return out;
}

/** The prop nearest to a point, and what the goal says there; everything in the room. */
export interface Felt {
  readonly prop: PropModel;
  readonly point: Vector3;
  /** Where that point shall appear. */
  readonly goal: Vector3;
}

/** All props where they stand in the room, for lookups of nearest places. */
export class PlacedProps extends PlacedSurfaces {
  private readonly foot = new SurfaceFoot();
  private readonly place = new Vector3();
  private readonly displayed: FollowedPoints;

  constructor(readonly props: readonly PropModel[]) {
    super(props.map(({ surface }) => surface));
    this.displayed = new FollowedPoints(
      props.map(({ virtualSurface }) => virtualSurface),
      10,
    );
  }

  /** The nearest place of any prop to a point of the room. */
  felt(point: Vector3): Felt {
    this.pose.toProp(point, this.place);
    let nearest = this.props[0]!;
    let least = Number.POSITIVE_INFINITY;
    for (const prop of this.props) {
      const distance = Math.abs(prop.surface.nearest(this.place, this.foot).distance);
      if (distance < least) [nearest, least] = [prop, distance];
    }
    nearest.surface.nearest(this.place, this.foot);
    return {
      prop: nearest,
      point: this.pose.toRoom(this.foot.point),
      goal: this.pose.toRoom(goalAt(nearest, this.foot, new Vector3())),
    };
  }

  /** Signed distance of a displayed fingertip, one of ten, from the nearest virtual surface, and the way out. */
  seen(finger: number, tip: Vector3, outward: Vector3): number {
    const { distance, gradient } = this.displayed.find(finger, this.pose.toProp(tip, this.place));
    outward.copy(gradient).applyQuaternion(this.pose.turn);
    return distance;
  }
}
