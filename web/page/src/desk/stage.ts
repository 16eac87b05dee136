import {
  ACESFilmicToneMapping,
  Box3,
  DirectionalLight,
  HemisphereLight,
  MathUtils,
  MOUSE,
  PCFShadowMap,
  PerspectiveCamera,
  type Ray,
  Raycaster,
  Scene,
  Sphere,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { HANDLES_REACH } from "./gizmo.js";
import { ALL, FELT, SEEN, TOGETHER } from "./layers.js";

/** One view of the scene: an element over the canvas, and the layer that it shows. */
export interface Pane {
  readonly element: HTMLElement;
  layer: number;
}

const SHADOW_TEXELS = 1024;
/** Around objects that are framed, a little room. */
const ROOM = 1.08;

/** The canvas with its two panes under one camera; it draws only when something has changed. */
export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(32, 1, 0.02, 20);
  readonly renderer: WebGLRenderer;
  readonly orbit: OrbitControls;
  readonly felt: Pane;
  readonly seen: Pane;
  /** Called before each frame that is drawn, with the time in ms. */
  beforeFrame: (time: number) => void = () => {};
  afterFrame: () => void = () => {};
  #split = true;
  #asked = false;
  #paused = true;
  #flight: ((time: number) => boolean) | null = null;
  #all = new Box3();
  #handles: readonly Vector3[] = [];
  #least = 0;
  #sun: DirectionalLight;

  constructor(
    readonly element: HTMLElement,
    canvas: HTMLCanvasElement,
  ) {
    this.felt = { element: element.querySelector<HTMLElement>(".pane.felt")!, layer: FELT };
    this.seen = { element: element.querySelector<HTMLElement>(".pane.seen")!, layer: SEEN };
    const plain = drawsInSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !plain, alpha: true });
    this.renderer.setPixelRatio(plain ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer.debug.checkShaderErrors = false; // asking would wait for the graphics processor
    this.renderer.toneMapping = ACESFilmicToneMapping;
    this.renderer.toneMappingExposure = 1.05;
    this.renderer.shadowMap.enabled = !plain;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.camera.up.set(0, 0, 1);

    const sky = new HemisphereLight(0xffffff, 0xb9b2a6, 1.9);
    sky.position.set(0, 0, 1);
    this.#sun = new DirectionalLight(0xfff4e6, 2.1);
    this.#sun.castShadow = true;
    this.#sun.shadow.mapSize.setScalar(SHADOW_TEXELS);
    this.#sun.shadow.radius = 5;
    this.#sun.shadow.bias = -0.0004;
    for (const light of [sky, this.#sun]) light.layers.enableAll();
    this.scene.add(sky, this.#sun, this.#sun.target);

    this.orbit = new OrbitControls(this.camera, element);
    this.orbit.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };
    this.orbit.maxPolarAngle = 0.495 * Math.PI;
    this.orbit.zoomToCursor = false;
    this.orbit.addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(element);
  }

  /** Two panes beside each other, or one that shows both. */
  set split(split: boolean) {
    this.#split = split;
    this.element.classList.toggle("together", !split);
    this.seen.layer = split ? SEEN : TOGETHER;
    this.draw();
  }

  get split(): boolean {
    return this.#split;
  }

  /** While paused nothing is drawn: at first, and while another mode has the screen. */
  set paused(paused: boolean) {
    this.#paused = paused;
    if (!paused) this.draw();
  }

  get paused(): boolean {
    return this.#paused;
  }

  /** Show all, as in the beginning. */
  home(): void {
    this.frame(this.#all, this.#handles, this.#least);
  }

  /** Come to this many times the distance. */
  nearer(factor: number): void {
    const { target, minDistance, maxDistance } = this.orbit;
    const away = this.camera.position.clone().sub(target);
    const distance = Math.min(Math.max(factor * away.length(), minDistance), maxDistance);
    this.camera.position.copy(target).add(away.setLength(distance));
    this.orbit.update();
  }

  /**
   * Look at a box from the front, half from above, from where the ball around it fits each pane.
   * @param handles where a gizmo may stand, which is to fit as well.
   * @param least the radius of the smallest object, m, which one may come near to.
   */
  frame(box: Box3, handles: readonly Vector3[], least: number): void {
    this.#all.copy(box);
    this.#handles = handles;
    this.#least = least;
    this.#flight = null;
    const ball = box.getBoundingSphere(new Sphere());
    this.orbit.target.copy(ball.center);
    const away = new Vector3(0.42, -1, 0.62).setLength(this.#distanceOf(ball));
    this.camera.position.copy(ball.center).add(away);
    this.camera.near = 0.05 * least;
    this.camera.far = 80 * ball.radius;
    this.orbit.minDistance = 0.6 * least;
    this.orbit.maxDistance = 20 * ball.radius;
    this.orbit.update();
    const reach = 4 * ball.radius;
    this.#sun.position.copy(ball.center).add(new Vector3(-0.9, -0.7, 2.2).multiplyScalar(reach));
    this.#sun.target.position.copy(ball.center);
    Object.assign(this.#sun.shadow.camera, {
      left: -reach,
      right: reach,
      top: reach,
      bottom: -reach,
      near: reach,
      far: 5 * reach,
    });
    this.#sun.shadow.camera.updateProjectionMatrix();
    // nearer to a surface than a few texels its own shadow would blotch it
    this.#sun.shadow.normalBias = 3 * ((2 * reach) / SHADOW_TEXELS);
    this.draw();
  }

  /** Turn and come near so that a place is seen. */
  flyTo(place: Vector3, distance: number): void {
    const fromTarget = this.orbit.target.clone();
    const fromPosition = this.camera.position.clone();
    const outwards = place.clone().sub(fromTarget).setZ(0);
    const away = fromPosition.clone().sub(fromTarget);
    if (outwards.length() > 1e-3) away.lerp(outwards.setLength(away.length()), 0.5);
    away.setZ(Math.max(away.z, 0.3 * away.length())).setLength(distance);
    const toPosition = place.clone().add(away);
    const begin = performance.now();
    this.#flight = (time) => {
      const t = Math.min((time - begin) / 700, 1);
      const eased = t * t * (3 - 2 * t);
      this.orbit.target.lerpVectors(fromTarget, place, eased);
      this.camera.position.lerpVectors(fromPosition, toPosition, eased);
      this.orbit.update();
      return t < 1;
    };
    this.draw();
  }

  /** The ray under the mouse, in the pane that it is over. */
  ray(pane: Pane, event: { clientX: number; clientY: number }): Ray {
    const box = pane.element.getBoundingClientRect();
    this.#aim(box.width / box.height);
    const place = new Vector2(
      (2 * (event.clientX - box.left)) / box.width - 1,
      1 - (2 * (event.clientY - box.top)) / box.height,
    );
    const caster = new Raycaster();
    caster.setFromCamera(place, this.camera);
    return caster.ray;
  }

  /** Ask for a frame. */
  draw(): void {
    if (this.#asked || this.#paused) return;
    this.#asked = true;
    requestAnimationFrame((time) => {
      this.#asked = false;
      if (this.#paused) return;
      if (this.#flight !== null && !this.#flight(time)) this.#flight = null;
      this.beforeFrame(time);
      this.#render();
      this.afterFrame();
      if (this.#flight !== null) this.draw();
    });
  }

  /** From how far a ball and the handles fit a pane, whichever of its sides is the narrower. */
  #distanceOf(ball: Sphere): number {
    const { width, height } = this.seen.element.getBoundingClientRect();
    const narrower = Math.min(width / height || 1, 1); // what is not laid out counts as square
    const upwards = Math.tan(MathUtils.degToRad(this.camera.fov / 2));
    const within = Math.sin(Math.atan(upwards * narrower));
    // handles are as large on the screen from everywhere; at most half of a pane is left to them
    const beside = Math.max(within - HANDLES_REACH * upwards, within / 2);
    const farthest = Math.max(0, ...this.#handles.map((place) => place.distanceTo(ball.center)));
    return Math.max((ROOM * ball.radius) / within, farthest / beside);
  }

  #aim(aspect: number): void {
    if (Math.abs(this.camera.aspect - aspect) < 1e-6) return;
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
  }

  #render(): void {
    const whole = this.element.getBoundingClientRect();
    if (whole.width === 0 || whole.height === 0) return;
    const size = this.renderer.getSize(new Vector2());
    if (size.x !== whole.width || size.y !== whole.height) {
      this.renderer.setSize(whole.width, whole.height, false);
    }
    this.renderer.setScissorTest(true);
    for (const pane of this.#split ? [this.felt, this.seen] : [this.seen]) {
      const box = pane.element.getBoundingClientRect();
      const left = box.left - whole.left;
      const low = whole.bottom - box.bottom;
      this.renderer.setViewport(left, low, box.width, box.height);
      this.renderer.setScissor(left, low, box.width, box.height);
      this.#aim(box.width / box.height);
      for (const layer of ALL) this.camera.layers.disable(layer);
      this.camera.layers.enable(pane.layer);
      this.renderer.render(this.scene, this.camera);
    }
  }
}

/**
 * Whether there is no graphics processor: then shadows and smooth edges would cost most of each
 * frame, and are left out unless the address asks for them by `?quality=full`.
 */
function drawsInSoftware(): boolean {
  if (new URLSearchParams(location.search).get("quality") === "full") return false;
  const probe = document.createElement("canvas").getContext("webgl2");
  const told = probe?.getExtension("WEBGL_debug_renderer_info");
  const name = told ? String(probe?.getParameter(told.UNMASKED_RENDERER_WEBGL)) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
