import {
  Box3,
  BufferAttribute,
  CanvasTexture,
  CircleGeometry,
  type Color,
  DoubleSide,
  Group,
  type Material,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  MeshStandardMaterial,
  Quaternion,
  Vector3,
} from "three";
import { acceleratedRaycast, MeshBVH } from "three-mesh-bvh";
import { ContactSurface } from "../calibrate/surface.js";
import type { Plane, PropState } from "../live/messages.js";
import { columns } from "../live/tables.js";
import { fetchSurface, geometryOf, type PackedSurface } from "../world/surface.js";
import { ALL, FELT, SEEN, showIn, TOGETHER } from "./layers.js";

/** A prop, its ghost, and its virtual object. */
export class PropObject {
  /** Solid and coloured where it is felt. */
  readonly prop: Mesh;
  readonly ghost: Mesh;
  /** What is seen instead; its matrix is the goal, or the identity where that is not affine. */
  readonly virtual: Mesh;
  readonly normals: Float32Array;
  /** Nearest places of the prop. */
  readonly contact: ContactSurface;

  private constructor(
    public state: PropState,
    readonly surface: PackedSurface,
  ) {
    const geometry = geometryOf(surface.prop, surface.faces);
    this.contact = new ContactSurface(surface.prop, surface.faces);
    geometry.setAttribute(
      "color",
      new BufferAttribute(new Float32Array(surface.prop.length).fill(1), 3),
    );
    this.normals = geometry.getAttribute("normal").array as Float32Array;
    const solid = new MeshStandardMaterial({ roughness: 0.75, side: DoubleSide });
    this.prop = new Mesh(geometry, solid);
    const faint = { color: 0x3a4654, transparent: true, opacity: 0.16, depthWrite: false };
    // behind a virtual object that has the same face: depths that are equal would blotch it
    const behind = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    this.ghost = new Mesh(geometry, new MeshLambertMaterial({ ...faint, ...behind }));
    const affine = state.goal !== null;
    const shown = affine ? geometry : geometryOf(surface.virtual, surface.faces);
    const china = new MeshStandardMaterial({ color: 0x3f8fc4, roughness: 0.32, side: DoubleSide });
    this.virtual = new Mesh(shown, china);
    this.virtual.matrixAutoUpdate = false;
    for (const mesh of [this.prop, this.virtual]) {
      mesh.geometry.boundsTree ??= new MeshBVH(mesh.geometry, { indirect: true });
      mesh.raycast = acceleratedRaycast;
      mesh.castShadow = true;
      mesh.receiveShadow = true;
    }
    this.ghost.renderOrder = 2;
    showIn(this.prop, [FELT]);
    showIn(this.ghost, [SEEN, TOGETHER]);
    showIn(this.virtual, [SEEN, TOGETHER]);
    if (state.goal !== null) this.moveVirtual(columns(state.goal));
  }

  static async fetch(state: PropState): Promise<PropObject> {
    return new PropObject(state, await fetchSurface(state.surface));
  }

  get objects(): Mesh[] {
    return [this.prop, this.ghost, this.virtual];
  }

  moveVirtual(goal: Float64Array): void {
    this.virtual.matrix.fromArray(goal);
    this.virtual.matrixWorldNeedsUpdate = true;
  }

  /** How far the virtual object reaches beyond a box, m; 0 within. */
  beyond(box: Box3): number {
    const point = new Vector3();
    let most = 0;
    for (let at = 0; at < this.surface.prop.length; at += 3) {
      point.fromArray(this.surface.prop, at).applyMatrix4(this.virtual.matrix);
      for (const axis of ["x", "y", "z"] as const) {
        most = Math.max(most, box.min[axis] - point[axis], point[axis] - box.max[axis]);
      }
    }
    return most;
  }

  /** The greatest mismatch in contact, m: |u| is nowhere greater (eq. 5 has a maximum principle). */
  greatestShift(): number {
    const { prop, virtual } = this.surface;
    const affine = this.state.goal !== null;
    const [from, to] = [new Vector3(), new Vector3()];
    let greatest = 0;
    for (let at = 0; at < prop.length; at += 3) {
      from.fromArray(prop, at);
      if (affine) to.copy(from).applyMatrix4(this.virtual.matrix);
      else to.fromArray(virtual, at);
      greatest = Math.max(greatest, from.distanceToSquared(to));
    }
    return Math.sqrt(greatest);
  }

  /** Colours of the prop's vertices, to be changed in place; see `paint`. */
  get colours(): Float32Array {
    return this.prop.geometry.getAttribute("color").array as Float32Array;
  }

  /** Show the colours, or one plain colour. */
  paint(plain: Color | null): void {
    const material = this.prop.material as MeshStandardMaterial;
    const painted = plain === null;
    if (material.vertexColors !== painted) {
      material.vertexColors = painted;
      material.needsUpdate = true;
    }
    if (plain === null) material.color.set(0xffffff);
    else material.color.copy(plain);
    this.prop.geometry.getAttribute("color").needsUpdate = true;
  }

  dispose(): void {
    for (const mesh of this.objects) {
      mesh.geometry.dispose();
      (mesh.material as Material).dispose();
      mesh.removeFromParent();
    }
  }
}

/** A fixed plane: a round of it around a place, fading out. */
export function planeObject(plane: Plane, around: Box3): Group {
  const group = new Group();
  const normal = new Vector3(...plane.normal);
  const centre = around.getCenter(new Vector3());
  centre.addScaledVector(
    normal,
    -centre
      .clone()
      .sub(new Vector3(...plane.point))
      .dot(normal),
  );
  const radius = 1.6 * around.getSize(new Vector3()).length();
  const fade = fadeTexture();
  const top = new Mesh(
    new CircleGeometry(radius, 96),
    new MeshLambertMaterial({
      color: 0xe9e2d6,
      alphaMap: fade,
      transparent: true,
      depthWrite: false,
    }),
  );
  top.receiveShadow = true;
  group.add(top);
  group.position.copy(centre).addScaledVector(normal, -2e-4);
  group.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal));
  group.renderOrder = -1;
  showIn(group, ALL);
  return group;
}

function fadeTexture(): CanvasTexture {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 256;
  const pen = canvas.getContext("2d")!;
  const fill = pen.createRadialGradient(128, 128, 0, 128, 128, 128);
  fill.addColorStop(0, "#fff");
  fill.addColorStop(0.55, "#ddd");
  fill.addColorStop(1, "#000");
  pen.fillStyle = fill;
  pen.fillRect(0, 0, 256, 256);
  return new CanvasTexture(canvas);
}

/** The box around props and their virtual objects. */
export function boxAround(props: readonly PropObject[]): Box3 {
  const box = new Box3();
  for (const { prop, virtual } of props) {
    box.expandByObject(prop);
    prop.geometry.computeBoundingBox();
    const shown =
      virtual.geometry.boundingBox ??
      new Box3().setFromBufferAttribute(
        virtual.geometry.getAttribute("position") as BufferAttribute,
      );
    box.union(shown.clone().applyMatrix4(new Matrix4().copy(virtual.matrix)));
  }
  return box;
}
