import {
  CylinderGeometry,
  Group,
  InstancedMesh,
  Matrix4,
  MeshStandardMaterial,
  Quaternion,
  SphereGeometry,
  Vector3,
} from "three";

/** Bones between joints, in WebXR's order of 25: fingers, and a fan that fills the palm. */
const BONES: readonly (readonly [number, number])[] = [
  ...[1, 5, 10, 15, 20].map((first) => [0, first] as const),
  ...[1, 2, 3].map((joint) => [joint, joint + 1] as const),
  ...[5, 10, 15, 20].flatMap((first) =>
    [0, 1, 2, 3].map((k) => [first + k, first + k + 1] as const),
  ),
  ...[5, 10, 15].map((first) => [first, first + 5] as const),
  ...[6, 11, 16].map((first) => [first, first + 5] as const),
  [1, 5],
  [2, 6],
];

const JOINTS = 25;
const UP = new Vector3(0, 1, 0);

/** A hand drawn as balls and tapered links; updated in place. */
export class HandPicture extends Group {
  readonly material: MeshStandardMaterial;
  #balls: InstancedMesh;
  #links: InstancedMesh;
  #matrix = new Matrix4();
  #turn = new Quaternion();
  #from = new Vector3();
  #to = new Vector3();
  #scale = new Vector3();

  constructor(color: number, opacity = 1) {
    super();
    this.material = new MeshStandardMaterial({
      color,
      roughness: 0.55,
      transparent: opacity < 1,
      opacity,
    });
    this.#balls = new InstancedMesh(new SphereGeometry(1, 18, 12), this.material, JOINTS);
    const link = new CylinderGeometry(1, 1, 1, 18, 1, true);
    this.#links = new InstancedMesh(link, this.material, BONES.length);
    for (const mesh of [this.#balls, this.#links]) {
      mesh.frustumCulled = false;
      mesh.castShadow = opacity === 1;
      this.add(mesh);
    }
  }

  /**
   * Place the joints.
   * @param positions rows of `stride` numbers from `offset`: (3, 0) points, (16, 12) matrices.
   * @param radii 25, m; NaN counts as 8 mm.
   */
  place(positions: ArrayLike<number>, radii: ArrayLike<number>, stride = 3, offset = 0): void {
    const at = (joint: number, out: Vector3) => {
      const start = stride * joint + offset;
      return out.set(positions[start]!, positions[start + 1]!, positions[start + 2]!);
    };
    for (let joint = 0; joint < JOINTS; joint++) {
      at(joint, this.#from);
      const lost = Number.isNaN(this.#from.x);
      const radius = lost ? 0 : thickness(radii, joint);
      this.#matrix.makeScale(radius, radius, radius);
      if (!lost) this.#matrix.setPosition(this.#from);
      this.#balls.setMatrixAt(joint, this.#matrix);
    }
    BONES.forEach(([a, b], bone) => {
      at(a, this.#from);
      at(b, this.#to);
      const length = this.#from.distanceTo(this.#to);
      if (!(length > 1e-6)) {
        this.#matrix.makeScale(0, 0, 0);
      } else {
        const radius = 0.96 * Math.min(thickness(radii, a), thickness(radii, b));
        this.#scale.set(radius, length, radius);
        this.#turn.setFromUnitVectors(UP, this.#to.clone().sub(this.#from).divideScalar(length));
        this.#from.add(this.#to).multiplyScalar(0.5);
        this.#matrix.compose(this.#from, this.#turn, this.#scale);
      }
      this.#links.setMatrixAt(bone, this.#matrix);
    });
    this.#balls.instanceMatrix.needsUpdate = true;
    this.#links.instanceMatrix.needsUpdate = true;
  }
}

function thickness(radii: ArrayLike<number>, joint: number): number {
  const radius = radii[joint]!;
  return Number.isFinite(radius) ? radius : 0.008;
}
