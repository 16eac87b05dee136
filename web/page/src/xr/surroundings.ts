import {
  BackSide,
  BufferAttribute,
  CanvasTexture,
  CircleGeometry,
  Color,
  CylinderGeometry,
  DirectionalLight,
  Group,
  HemisphereLight,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  Quaternion,
  SphereGeometry,
  SRGBColorSpace,
  Vector3,
} from "three";
import type { Plane } from "../live/messages.js";

const [ZENITH, HORIZON, NADIR] = [0x9fb4c6, 0xeef1f2, 0xc9c3b8].map((hex) => new Color(hex));
/** While nothing virtual is to be seen and the device cannot show the real room. */
const CALM = new Color(0x4a525b);
const PLAIN = new Color(0xffffff);
const WOOD = 0xc8a67e;
const TABLE_RADIUS = 0.42;
const TABLE_THICKNESS = 0.025;
/** How far around the prop shadows are drawn, m. */
const SHADOWED = 0.45;

/** What is around the objects in the headset: sky, floor and light. */
export class Surroundings extends Group {
  #sky: Mesh<SphereGeometry, MeshBasicMaterial>;
  #floor: Mesh<CircleGeometry, MeshBasicMaterial>;
  readonly sun = new DirectionalLight(0xfff2e0, 2.2);

  constructor() {
    super();
    const dome = new SphereGeometry(15, 32, 24);
    paintDome(dome);
    const look = { side: BackSide, transparent: true, vertexColors: true, depthWrite: false };
    this.#sky = new Mesh(dome, new MeshBasicMaterial(look));
    this.#sky.renderOrder = -10;
    const tiles = { map: floorTexture(), transparent: true, depthWrite: false };
    this.#floor = new Mesh(new CircleGeometry(6, 64), new MeshBasicMaterial(tiles));
    this.#floor.rotateX(-Math.PI / 2);
    this.#floor.renderOrder = -9;
    const light = new HemisphereLight(0xffffff, 0xb3a795, 1.7);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.radius = 4;
    this.sun.shadow.bias = -0.0004;
    const [low, high] = [-SHADOWED, SHADOWED];
    Object.assign(this.sun.shadow.camera, { left: low, right: high, bottom: low, top: high });
    Object.assign(this.sun.shadow.camera, { near: 0.2, far: 2.6 });
    this.add(light, this.sun, this.sun.target, this.#sky, this.#floor);
    this.lookAround(new Vector3(0, 1, 0));
  }

  /**
   * @param cover how much of the real room is hidden, 0 to 1
   * @param world how much of the virtual world is to be seen, 0 to 1
   */
  show(cover: number, world: number): void {
    this.#sky.material.opacity = cover;
    this.#sky.material.color.copy(CALM).lerp(PLAIN, world);
    this.#floor.material.opacity = cover * world;
    this.#sky.visible = cover > 0.001;
    this.#floor.visible = cover * world > 0.001;
  }

  /** Light the surroundings of a place. */
  lookAround(place: Vector3): void {
    this.sun.target.position.copy(place);
    this.sun.position.copy(place).add(SUNWARD);
  }
}

const SUNWARD = new Vector3(-0.5, 1.3, 0.35);

/** A fixed plane of the scene: a table top where it is level, else a board; scene frame. */
export function boardOf(plane: Plane, around: Vector3): Group {
  const group = new Group();
  const normal = new Vector3(...plane.normal);
  const foot = around.clone();
  foot.addScaledVector(normal, new Vector3(...plane.point).sub(around).dot(normal));
  const wood = new MeshStandardMaterial({ color: WOOD, roughness: 0.85 });
  const top = new CylinderGeometry(TABLE_RADIUS, TABLE_RADIUS, TABLE_THICKNESS, 96);
  top.rotateX(Math.PI / 2).translate(0, 0, -TABLE_THICKNESS / 2);
  const board = new Mesh(top, wood);
  board.receiveShadow = true;
  group.add(board);
  group.position.copy(foot).addScaledVector(normal, -3e-4);
  group.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal));
  return group;
}

function paintDome(dome: SphereGeometry): void {
  const { position } = dome.attributes;
  const colours = new Float32Array(3 * position!.count);
  const colour = new Color();
  for (let n = 0; n < position!.count; n++) {
    const height = position!.getY(n) / 15;
    if (height > 0) colour.copy(HORIZON!).lerp(ZENITH!, height ** 0.7);
    else colour.copy(HORIZON!).lerp(NADIR!, Math.min(1, -3 * height));
    colour.toArray(colours, 3 * n);
  }
  dome.setAttribute("color", new BufferAttribute(colours, 3));
}

/** Half-metre squares that fade out. */
function floorTexture(): CanvasTexture {
  const size = 1024;
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  const pen = canvas.getContext("2d")!;
  pen.fillStyle = "#cdc7bb";
  pen.fillRect(0, 0, size, size);
  pen.strokeStyle = "#bdb5a7";
  pen.lineWidth = 2;
  for (let k = 0; k <= 24; k++) {
    const at = (k / 24) * size;
    pen.strokeRect(at, -10, size, size + 20);
    pen.strokeRect(-10, at, size + 20, size);
  }
  pen.globalCompositeOperation = "destination-in";
  const fade = pen.createRadialGradient(size / 2, size / 2, 0, size / 2, size / 2, size / 2);
  fade.addColorStop(0, "rgba(0,0,0,1)");
  fade.addColorStop(0.3, "rgba(0,0,0,0.8)");
  fade.addColorStop(1, "rgba(0,0,0,0)");
  pen.fillStyle = fade;
  pen.fillRect(0, 0, size, size);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
}
