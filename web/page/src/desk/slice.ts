import { interpolateViridis } from "d3-scale-chromatic";
import {
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  ConeGeometry,
  CylinderGeometry,
  DoubleSide,
  Group,
  InstancedMesh,
  LineBasicMaterial,
  LineLoop,
  LineSegments,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  type Plane,
  PlaneGeometry,
  Quaternion,
  type Ray,
  SphereGeometry,
  Vector3,
} from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { Warp } from "touchwarp";
import { ALL, FELT, SEEN, showIn, TOGETHER } from "./layers.js";

export type SliceMode = "off" | "arrows" | "lattice";
export type Axis = 0 | 1 | 2;

const ARROWS = 30;
const LINES = 34;
const STEPS = 102;
/** Shorter displacements than this are not drawn, m. */
const LEAST = 2e-4;

/** A plane through the field of displacement: arrows from real to displayed, or a lattice warped. */
export class Slice extends Group {
  mode: SliceMode = "off";
  axis: Axis = 1;
  /** Where along the axis, 0 to 1 of the box. */
  share = 0.5;
  #box = new Box3();
  #frame = new LineLoop(
    new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(12), 3)),
    new LineBasicMaterial({ color: 0x1d2126, transparent: true, opacity: 0.55 }),
  );
  #pane = new Mesh(
    new PlaneGeometry(1, 1),
    new MeshBasicMaterial({
      color: 0x56b4e9,
      transparent: true,
      opacity: 0.06,
      side: DoubleSide,
      depthWrite: false,
    }),
  );
  #knob = new Mesh(
    new SphereGeometry(1, 24, 16),
    new MeshStandardMaterial({ color: 0xe08a1e, roughness: 0.4 }),
  );
  #arrows = new InstancedMesh(
    arrowGeometry(),
    new MeshStandardMaterial({ roughness: 0.6 }),
    ARROWS * ARROWS,
  );
  #real = lattice(0x5a626c, 0.45);
  #warped = lattice(0x0072b2, 0.9);

  constructor() {
    super();
    this.#arrows.frustumCulled = false;
    this.#real.frustumCulled = this.#warped.frustumCulled = this.#frame.frustumCulled = false;
    this.add(this.#frame, this.#pane, this.#knob, this.#arrows, this.#real, this.#warped);
    showIn(this, ALL);
    showIn(this.#real, [FELT]);
    showIn(this.#warped, [SEEN, TOGETHER]);
    this.visible = false;
  }

  /** Move through the surroundings of a box, within ∂Ω1 and above tables. */
  surround(around: Box3, outer: Box3, tables: readonly Plane[]): void {
    const size = around.getSize(new Vector3());
    this.#box.copy(around).expandByVector(size.multiplyScalar(0.45)).intersect(outer);
    for (const { normal, constant } of tables) {
      if (normal.z > 0.999) this.#box.min.z = Math.max(this.#box.min.z, -constant + 1e-4);
    }
  }

  /** Where the plane stands along its axis, m. */
  get place(): number {
    const low = this.#box.min.getComponent(this.axis);
    return low + this.share * (this.#box.max.getComponent(this.axis) - low);
  }

  /**
   * Draw the plane anew, after any change or with another warp.
   * @param most the greatest |u| anywhere, m: the end of the arrows' colours.
   */
  update(warp: Warp | null, most: number): void {
    this.visible = this.mode !== "off" && warp !== null;
    if (!this.visible || warp === null) return;
    this.#placeFrame();
    this.#arrows.visible = this.mode === "arrows";
    this.#real.visible = this.#warped.visible = this.mode === "lattice";
    if (this.mode === "arrows") this.#drawArrows(warp, most);
    else this.#drawLattice(warp);
  }

  /** Whether a ray hits the knob to drag the plane by. */
  hit(ray: Ray): boolean {
    const centre = this.#knob.position;
    return this.visible && ray.distanceToPoint(centre) < 2.2 * this.#knob.scale.x;
  }

  /** Move the plane so that its knob comes nearest to the ray. */
  drag(ray: Ray): void {
    const along = new Vector3().setComponent(this.axis, 1);
    const between = this.#knob.position.clone().sub(ray.origin);
    const b = along.dot(ray.direction);
    const denominator = 1 - b * b;
    if (denominator < 1e-4) return; // seen along the axis: there is nothing to drag by
    const step = (b * ray.direction.dot(between) - along.dot(between)) / denominator;
    const low = this.#box.min.getComponent(this.axis);
    const width = this.#box.max.getComponent(this.axis) - low;
    this.share = Math.min(1, Math.max(0, (this.place + step - low) / width));
  }

  #others(): [Axis, Axis] {
    return this.axis === 0 ? [1, 2] : this.axis === 1 ? [0, 2] : [0, 1];
  }

  /** The point at shares (s, t) of the plane. */
  #point(s: number, t: number, out: Vector3): Vector3 {
    const [a, b] = this.#others();
    const { min, max } = this.#box;
    out.setComponent(this.axis, this.place);
    out.setComponent(a, min.getComponent(a) + s * (max.getComponent(a) - min.getComponent(a)));
    return out.setComponent(
      b,
      min.getComponent(b) + t * (max.getComponent(b) - min.getComponent(b)),
    );
  }

  #placeFrame(): void {
    const corner = new Vector3();
    const attribute = this.#frame.geometry.getAttribute("position") as BufferAttribute;
    const corners = [
      [0, 0],
      [1, 0],
      [1, 1],
      [0, 1],
    ] as const;
    corners.forEach(([s, t], i) => {
      this.#point(s, t, corner);
      attribute.setXYZ(i, corner.x, corner.y, corner.z);
    });
    attribute.needsUpdate = true;
    const size = this.#box.getSize(new Vector3());
    const [a, b] = this.#others();
    this.#point(0.5, 0.5, this.#pane.position);
    this.#pane.scale.set(size.getComponent(a), size.getComponent(b), 1);
    const x = new Vector3().setComponent(a, 1);
    const y = new Vector3().setComponent(b, 1);
    const basis = new Matrix4().makeBasis(x, y, new Vector3().crossVectors(x, y));
    this.#pane.quaternion.setFromRotationMatrix(basis);
    this.#point(0.5, 1, this.#knob.position);
    this.#knob.scale.setScalar(0.016 * size.length());
  }

  #drawArrows(warp: Warp, most: number): void {
    const points = new Float64Array(3 * ARROWS * ARROWS);
    const place = new Vector3();
    for (let i = 0; i < ARROWS; i++) {
      for (let j = 0; j < ARROWS; j++) {
        this.#point((i + 0.5) / ARROWS, (j + 0.5) / ARROWS, place);
        place.toArray(points, 3 * (i * ARROWS + j));
      }
    }
    const moves = new Float64Array(points.length);
    warp.displacement(points, moves);
    const width = 0.0032 * this.#box.getSize(new Vector3()).length();
    const [u, turn, matrix] = [new Vector3(), new Quaternion(), new Matrix4()];
    const [up, scale, colour] = [new Vector3(0, 1, 0), new Vector3(), new Color()];
    for (let n = 0; n < ARROWS * ARROWS; n++) {
      u.fromArray(moves, 3 * n);
      const length = u.length();
      if (length > LEAST) {
        place.fromArray(points, 3 * n);
        turn.setFromUnitVectors(up, u.divideScalar(length));
        const thick = Math.min(width, 0.35 * length);
        matrix.compose(place, turn, scale.set(thick, length, thick));
        this.#arrows.setColorAt(
          n,
          colour.set(interpolateViridis(Math.min(1, length / Math.max(most, LEAST)))),
        );
      } else {
        matrix.makeScale(0, 0, 0);
        this.#arrows.setColorAt(n, colour.set(0));
      }
      this.#arrows.setMatrixAt(n, matrix);
    }
    this.#arrows.instanceMatrix.needsUpdate = true;
    this.#arrows.instanceColor!.needsUpdate = true;
  }

  #drawLattice(warp: Warp): void {
    const real = this.#real.geometry.getAttribute("position") as BufferAttribute;
    const warped = this.#warped.geometry.getAttribute("position") as BufferAttribute;
    const points = real.array as Float32Array;
    const place = new Vector3();
    let at = 0;
    for (const crosswise of [false, true]) {
      for (let line = 0; line <= LINES; line++) {
        for (let step = 0; step < STEPS; step++) {
          for (const end of [step / STEPS, (step + 1) / STEPS]) {
            const across = line / LINES;
            this.#point(crosswise ? end : across, crosswise ? across : end, place);
            place.toArray(points, at);
            at += 3;
          }
        }
      }
    }
    warp.displayed(points, warped.array as Float32Array);
    real.needsUpdate = warped.needsUpdate = true;
  }
}

function lattice(color: number, opacity: number): LineSegments {
  const count = 3 * 4 * (LINES + 1) * STEPS;
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(count), 3));
  return new LineSegments(geometry, new LineBasicMaterial({ color, transparent: true, opacity }));
}

/** An arrow of length 1 along y from the origin. */
function arrowGeometry(): BufferGeometry {
  const shaft = new CylinderGeometry(0.32, 0.32, 0.7, 8).translate(0, 0.35, 0);
  const head = new ConeGeometry(1, 0.34, 12).translate(0, 0.83, 0);
  return mergeGeometries([shaft, head]);
}
