import { Box3, Vector3 } from "three";
import { DistanceField } from "./field.js";
import { Triangles } from "./triangles.js";

/** What the surface says of a point near it: signed distance, and where that comes from. */
export class SurfaceFoot {
  /** Metres; negative below the surface. */
  distance = 0;
  readonly point = new Vector3();
  /** Unit gradient of the signed distance. */
  readonly gradient = new Vector3();
  face = 0;

  copy(other: SurfaceFoot): this {
    this.distance = other.distance;
    this.point.copy(other.point);
    this.gradient.copy(other.gradient);
    this.face = other.face;
    return this;
  }
}

/** A prop's surface for nearest-point queries: triangles in the prop frame, metres. */
export class ContactSurface {
  readonly centre = new Vector3();
  /** Half the diagonal of the bounding box. */
  readonly reach: number;
  readonly lowest = new Vector3();
  readonly highest = new Vector3();
  private grid: DistanceField | undefined;
  private readonly triangles: Triangles;
  private readonly normals: Float32Array;

  /**
   * @param positions (n, 3) row by row, m, prop frame
   * @param faces (m, 3) indices, outward by the right-hand rule
   */
  constructor(
    readonly positions: Float32Array,
    readonly faces: Uint32Array | Int32Array,
  ) {
    if (faces.length < 3) {
      throw new RangeError("The prop's outline has no triangle; calibration needs its surface.");
    }
    const box = new Box3().setFromArray(positions);
    box.getCenter(this.centre);
    this.lowest.copy(box.min);
    this.highest.copy(box.max);
    this.reach = box.min.distanceTo(box.max) / 2;
    this.normals = angleWeightedNormals(positions, faces);
    this.triangles = new Triangles(positions, faces);
  }

  /** The signed distance on a grid, made at first use. */
  get field(): DistanceField {
    this.grid ??= new DistanceField(this);
    return this.grid;
  }

  /** The nearest point of the surface to `point`, prop frame; `foot` is filled and returned. */
  nearest(point: Vector3, foot: SurfaceFoot): SurfaceFoot;
  /** The same, with a bound to its distance, m, which spares most of the search; null if it does not hold. */
  nearest(point: Vector3, foot: SurfaceFoot, within: number): SurfaceFoot | null;
  nearest(point: Vector3, foot: SurfaceFoot, within = Number.POSITIVE_INFINITY) {
    const { triangles } = this;
    if (!triangles.find(point.x, point.y, point.z, within)) return null;
    foot.face = triangles.face;
    foot.point.set(triangles.x, triangles.y, triangles.z);
    this.smoothNormal(foot.face, triangles.s, triangles.t, smooth);
    foot.gradient.subVectors(point, foot.point);
    const distance = foot.gradient.length();
    const sign = foot.gradient.dot(smooth) < 0 ? -1 : 1;
    foot.distance = sign * distance;
    if (distance > 1e-7) foot.gradient.multiplyScalar(sign / distance);
    else foot.gradient.copy(smooth);
    return foot;
  }

  /** Barycentric weights of a point of a face, in `out`. */
  weights(face: number, point: Vector3, out: Vector3): Vector3 {
    const origin = this.corner(face, 0, from);
    const u = this.corner(face, 1, first).sub(origin);
    const v = this.corner(face, 2, second).sub(origin);
    const w = third.subVectors(point, origin);
    const [uu, uv, vv, wu, wv] = [u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v)];
    const area = uu * vv - uv * uv;
    if (area <= 0) return out.set(1, 0, 0);
    const s = (vv * wu - uv * wv) / area;
    const t = (uu * wv - uv * wu) / area;
    return out.set(1 - s - t, s, t);
  }

  /** Points of the surface with outward normals, about evenly spread by area; the same each time. */
  sample(count: number): { point: Vector3; normal: Vector3 }[] {
    const areas = new Float64Array(this.faces.length / 3 + 1);
    const edge = new Vector3();
    for (let face = 0; face + 1 < areas.length; face++) {
      const [a, b, c] = this.corners(face);
      areas[face + 1] = areas[face]! + edge.subVectors(b, a).cross(c.sub(a)).length() / 2;
    }
    const total = areas[areas.length - 1]!;
    const samples = [];
    let face = 0;
    for (let k = 0; k < count; k++) {
      const target = ((k + 0.5) / count) * total;
      while (areas[face + 1]! < target) face++;
      // The R2 sequence spreads the points within faces without a random generator.
      let s = (0.5 + k * 0.7548776662466927) % 1;
      let t = (0.5 + k * 0.5698402909980532) % 1;
      if (s + t > 1) [s, t] = [1 - s, 1 - t];
      const [a, b, c] = this.corners(face);
      const normal = new Vector3().subVectors(b, a).cross(edge.subVectors(c, a)).normalize();
      const point = a.clone().addScaledVector(b.sub(a), s).addScaledVector(c.sub(a), t);
      samples.push({ point, normal });
    }
    return samples;
  }

  private corners(face: number): [Vector3, Vector3, Vector3] {
    return [
      this.corner(face, 0, new Vector3()),
      this.corner(face, 1, new Vector3()),
      this.corner(face, 2, new Vector3()),
    ];
  }

  private corner(face: number, k: number, out: Vector3): Vector3 {
    return out.fromArray(this.positions, 3 * this.faces[3 * face + k]!);
  }

  /** Interpolated normal of the vertices: its sign is right also where an edge is nearest. */
  private smoothNormal(face: number, s: number, t: number, out: Vector3): void {
    const { faces, normals } = this;
    const a = 3 * faces[3 * face]!;
    const b = 3 * faces[3 * face + 1]!;
    const c = 3 * faces[3 * face + 2]!;
    const r = 1 - s - t;
    out.set(
      r * normals[a]! + s * normals[b]! + t * normals[c]!,
      r * normals[a + 1]! + s * normals[b + 1]! + t * normals[c + 1]!,
      r * normals[a + 2]! + s * normals[b + 2]! + t * normals[c + 2]!,
    );
    out.normalize();
  }
}

const from = new Vector3();
const first = new Vector3();
const second = new Vector3();
const third = new Vector3();
const smooth = new Vector3();

/** Unit normals of the vertices, each face weighted by its angle there (Bærentzen & Aanæs 2005). */
function angleWeightedNormals(
  positions: Float32Array,
  faces: Uint32Array | Int32Array,
): Float32Array {
  const normals = new Float32Array(positions.length);
  const corners = [new Vector3(), new Vector3(), new Vector3()];
  const [normal, one, other] = [new Vector3(), new Vector3(), new Vector3()];
  for (let face = 0; face < faces.length; face += 3) {
    for (let k = 0; k < 3; k++) corners[k]!.fromArray(positions, 3 * faces[face + k]!);
    one.subVectors(corners[1]!, corners[0]!);
    normal.subVectors(corners[2]!, corners[0]!);
    normal.crossVectors(one, normal).normalize();
    for (let k = 0; k < 3; k++) {
      one.subVectors(corners[(k + 1) % 3]!, corners[k]!);
      other.subVectors(corners[(k + 2) % 3]!, corners[k]!);
      const angle = one.angleTo(other);
      for (let axis = 0; axis < 3; axis++) {
        normals[3 * faces[face + k]! + axis]! += angle * normal.getComponent(axis);
      }
    }
  }
  return normals;
}
