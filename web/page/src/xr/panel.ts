import {
  CanvasTexture,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  type Ray,
  SRGBColorSpace,
  Vector3,
} from "three";

/** A button of the panel. */
export interface Button {
  readonly label: string;
  readonly press: () => void;
}

/** What the panel shows. */
export interface PanelContent {
  readonly title: string;
  readonly lines: readonly string[];
  readonly buttons: readonly Button[];
  /** 0 to 1; null hides the bar. */
  readonly progress: number | null;
}

const WIDTH = 0.3;
const HEIGHT = 0.2;
/** Pixels a metre. */
const FINE = 2560;
const BUTTON_HEIGHT = 0.034;
const MARGIN = 0.014;

/** A card in the air with text and buttons, to be poked with a fingertip or pinched from afar. */
export class Panel extends Mesh<PlaneGeometry, MeshBasicMaterial> {
  #canvas = document.createElement("canvas");
  #texture: CanvasTexture;
  #content: PanelContent = { title: "", lines: [], buttons: [], progress: null };
  #drawn = "";
  /** Which finger is beyond the panel's plane; a button is pressed when one passes it. */
  #beyond = new Map<string, boolean>();
  #place = new Vector3();

  constructor() {
    super(new PlaneGeometry(WIDTH, HEIGHT), new MeshBasicMaterial({ transparent: true }));
    this.#canvas.width = WIDTH * FINE;
    this.#canvas.height = HEIGHT * FINE;
    this.#texture = new CanvasTexture(this.#canvas);
    this.#texture.colorSpace = SRGBColorSpace;
    this.#texture.anisotropy = 4;
    this.material.map = this.#texture;
    this.material.toneMapped = false;
    this.renderOrder = 5;
  }

  set content(content: PanelContent) {
    this.#content = content;
    const labels = content.buttons.map(({ label }) => label);
    const key = JSON.stringify([content.title, content.lines, labels, content.progress]);
    if (key === this.#drawn) return;
    this.#drawn = key;
    this.#draw();
  }

  get content(): PanelContent {
    return this.#content;
  }

  /** Stand where the person sees it, a forearm away, to the side of `direction`. */
  standBefore(head: Vector3, direction: Vector3, side = -0.2): void {
    const ahead = direction.clone().setY(0).normalize();
    const aside = new Vector3(-ahead.z, 0, ahead.x).multiplyScalar(side);
    this.position.copy(head).addScaledVector(ahead, 0.46).add(aside);
    this.position.y -= 0.14;
    this.lookAt(head);
  }

  /** Follow a fingertip; presses the button that it pushes through. */
  poke(finger: string, tip: Vector3): void {
    if (!Number.isFinite(tip.x)) {
      this.#beyond.delete(finger);
      return;
    }
    this.worldToLocal(this.#place.copy(tip));
    const { x, y, z } = this.#place;
    const before = this.#beyond.get(finger);
    const beyond = z < 0.004;
    this.#beyond.set(finger, beyond);
    if (before !== false || !beyond || z < -0.05) return;
    this.#buttonAt(x, y)?.press();
  }

  /** Press what a ray points at; false when it misses the panel. */
  select(ray: Ray): boolean {
    const normal = this.getWorldDirection(new Vector3());
    const centre = this.getWorldPosition(new Vector3());
    const along = ray.direction.dot(normal);
    if (Math.abs(along) < 1e-6) return false;
    const distance = centre.sub(ray.origin).dot(normal) / along;
    if (distance < 0) return false;
    const { x, y } = this.worldToLocal(ray.at(distance, new Vector3()));
    if (Math.abs(x) > WIDTH / 2 || Math.abs(y) > HEIGHT / 2) return false;
    this.#buttonAt(x, y)?.press();
    return true;
  }

  /** Where a button is, in the panel's frame: its middle. */
  middleOf(label: string): Vector3 | null {
    const index = this.#content.buttons.findIndex((button) => button.label === label);
    if (index < 0) return null;
    const width = this.#buttonWidth();
    const x = -WIDTH / 2 + MARGIN + (index + 0.5) * width + index * MARGIN;
    return new Vector3(x, -HEIGHT / 2 + MARGIN + BUTTON_HEIGHT / 2, 0);
  }

  #buttonWidth(): number {
    const count = Math.max(this.#content.buttons.length, 1);
    return (WIDTH - (count + 1) * MARGIN) / count;
  }

  #buttonAt(x: number, y: number): Button | null {
    for (const button of this.#content.buttons) {
      const middle = this.middleOf(button.label)!;
      const wide = Math.abs(x - middle.x) <= this.#buttonWidth() / 2;
      if (wide && Math.abs(y - middle.y) <= BUTTON_HEIGHT / 2) return button;
    }
    return null;
  }

  #draw(): void {
    const pen = this.#canvas.getContext("2d")!;
    const { width, height } = this.#canvas;
    const { title, lines, buttons, progress } = this.#content;
    pen.clearRect(0, 0, width, height);
    pen.fillStyle = "rgba(22, 27, 33, 0.93)";
    pen.beginPath();
    pen.roundRect(0, 0, width, height, 0.012 * FINE);
    pen.fill();
    const left = MARGIN * FINE;
    pen.textBaseline = "alphabetic";
    pen.fillStyle = "#ffffff";
    pen.font = `600 ${0.0135 * FINE}px "Segoe UI", Roboto, Arial, sans-serif`;
    pen.fillText(title, left, 0.024 * FINE, width - 2 * left);
    pen.fillStyle = "#cfd6dd";
    pen.font = `${0.0098 * FINE}px "Segoe UI", Roboto, Arial, sans-serif`;
    lines.forEach((line, k) => {
      pen.fillText(line, left, (0.044 + 0.0155 * k) * FINE, width - 2 * left);
    });
    if (progress !== null) {
      const top = height - (BUTTON_HEIGHT + 1.75 * MARGIN) * FINE;
      pen.fillStyle = "#3a434d";
      pen.fillRect(left, top, width - 2 * left, 0.003 * FINE);
      pen.fillStyle = "#3ad6c4";
      pen.fillRect(
        left,
        top,
        (width - 2 * left) * Math.min(Math.max(progress, 0), 1),
        0.003 * FINE,
      );
    }
    pen.textAlign = "center";
    for (const { label } of buttons) {
      const { x, y } = this.middleOf(label)!;
      const w = this.#buttonWidth() * FINE;
      const h = BUTTON_HEIGHT * FINE;
      const centreX = (x + WIDTH / 2) * FINE;
      const centreY = (HEIGHT / 2 - y) * FINE;
      pen.fillStyle = "#2f6fd0";
      pen.beginPath();
      pen.roundRect(centreX - w / 2, centreY - h / 2, w, h, 0.007 * FINE);
      pen.fill();
      pen.fillStyle = "#ffffff";
      pen.font = `600 ${0.0105 * FINE}px "Segoe UI", Roboto, Arial, sans-serif`;
      pen.fillText(label, centreX, centreY + 0.0037 * FINE, w - 0.01 * FINE);
    }
    pen.textAlign = "left";
    this.#texture.needsUpdate = true;
  }
}
