import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DynamicDrawUsage,
  EqualDepth,
  Group,
  Mesh,
  MeshLambertMaterial,
} from "three";
import { Balls, skinFaces, tipVertices, VERTEX_COUNT, writeSkin } from "./hand_shape.js";

const FACES = skinFaces();
const TIPS = tipVertices();
const TOUCHING = new Color(0x17b8a0);

/** A hand as it is drawn; updated in place. */
export class HandPicture extends Group {
  readonly material: MeshLambertMaterial;
  #balls = new Balls();
  #positions = dynamic();
  #normals = dynamic();
  #colours = dynamic();
  #skin: Color;
  #touching = 0;

  constructor(colour: number, opacity = 1) {
    super();
    this.#skin = new Color(colour);
    this.material = new MeshLambertMaterial({
      vertexColors: true,
      transparent: opacity < 1,
      opacity,
    });
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.#positions);
    geometry.setAttribute("normal", this.#normals);
    geometry.setAttribute("color", this.#colours);
    geometry.setIndex(new BufferAttribute(FACES, 1));
    const skin = new Mesh(geometry, this.material);
    if (opacity < 1) {
      // Depth first, so that of a glassy hand only the outside is seen. By the same shader: equal
      // depths are equal then.
      const depth = this.material.clone();
      depth.colorWrite = false;
      this.material.depthFunc = EqualDepth;
      const before = new Mesh(geometry, depth);
      before.renderOrder = 3;
      skin.renderOrder = 4;
      this.add(before);
    }
    skin.castShadow = opacity === 1;
    this.add(skin);
    for (const mesh of this.children) mesh.frustumCulled = false;
    this.#paint();
  }

  /**
   * Place the joints.
   * @param positions rows of `stride` numbers from `offset`: (3, 0) points, (16, 12) matrices.
   * @param radii 25, m; NaN counts as 8 mm.
   */
  place(positions: ArrayLike<number>, radii: ArrayLike<number>, stride = 3, offset = 0): void {
    this.#balls.place(positions, radii, stride, offset);
    writeSkin(this.#balls, this.#positions.array, this.#normals.array);
    this.#positions.needsUpdate = this.#normals.needsUpdate = true;
  }

  /** Light up the fingertips that touch: bit 0 the thumb … bit 4 the little finger. */
  touch(fingers: number): void {
    if (fingers === this.#touching) return;
    this.#touching = fingers;
    this.#paint();
  }

  #paint(): void {
    const colours = this.#colours.array;
    for (let n = 0; n < VERTEX_COUNT; n++) this.#skin.toArray(colours, 3 * n);
    TIPS.forEach((vertices, finger) => {
      if (!(this.#touching & (1 << finger))) return;
      for (const vertex of vertices) TOUCHING.toArray(colours, 3 * vertex);
    });
    this.#colours.needsUpdate = true;
  }
}

function dynamic(): BufferAttribute & { array: Float32Array } {
  const attribute = new BufferAttribute(new Float32Array(3 * VERTEX_COUNT), 3);
  attribute.setUsage(DynamicDrawUsage);
  return attribute as BufferAttribute & { array: Float32Array };
}
