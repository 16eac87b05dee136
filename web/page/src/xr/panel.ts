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

/** A quantity that has to become small enough: `share` of what is allowed, 1 or below will do. */
export interface Measure {
  readonly name: string;
  readonly value: string;
  readonly share: number;
}

/** What the panel shows. */
export interface PanelContent {
  readonly title: string;
  readonly lines: readonly string[];
  readonly measures: readonly Measure[];
  readonly buttons: readonly Button[];
  /** 0 to 1; null hides the bar. */
  readonly progress: number | null;
  /** Whose hands are being recorded; null while nobody's are. */
  readonly recording: string | null;
}

const WIDTH = 0.36;
const HEIGHT = 0.24;
/** Pixels a metre. */
const FINE = 2800;
const BUTTON_HEIGHT = 0.036;
const MARGIN = 0.012;
/** What is drawn is laid out in mm. */
const [WIDE, HIGH, EDGE] = [1e3 * WIDTH, 1e3 * HEIGHT, 1e3 * MARGIN];
const [TITLE, TEXT, SMALL] = [16.5, 11.8, 10.4];
const FONT = '"Segoe UI", Roboto, "Helvetica Neue", Arial, "Liberation Sans", sans-serif';
const [GOOD, POOR, RED] = ["#3ad6c4", "#f0a63a", "#ff6b57"];

/** A card in the air with text and buttons, to be poked with a fingertip or pinched from afar. */
export class Panel extends Mesh<PlaneGeometry, MeshBasicMaterial> {
  #canvas = document.createElement("canvas");
  #texture: CanvasTexture;
  #content: PanelContent = {
    title: "",
    lines: [],
    measures: [],
    buttons: [],
    progress: null,
    recording: null,
  };
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
    const { buttons, ...rest } = content;
    const key = JSON.stringify([rest, buttons.map(({ label }) => label)]);
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
    this.position.copy(head).addScaledVector(ahead, 0.5).add(aside);
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

  /** The button that a ray points at. */
  pointedAt(ray: Ray): Button | null {
    const normal = this.getWorldDirection(new Vector3());
    const centre = this.getWorldPosition(new Vector3());
    const along = ray.direction.dot(normal);
    if (Math.abs(along) < 1e-6) return null;
    const distance = centre.sub(ray.origin).dot(normal) / along;
    if (distance < 0) return null;
    const { x, y } = this.worldToLocal(ray.at(distance, new Vector3()));
    return this.#buttonAt(x, y);
  }

  /** Where a button is, in the panel's frame: its middle. */
  middleOf(label: string): Vector3 | null {
    const index = this.#content.buttons.findIndex((button) => button.label === label);
    if (index < 0) return null;
    const width = this.#buttonWidth();
    const x = -WIDTH / 2 + MARGIN + (index + 0.5) * width + index * MARGIN;
    return new Vector3(x, -HEIGHT / 2 + MARGIN + BUTTON_HEIGHT / 2, 0);
  }

  override dispose(): void {
    super.dispose();
    this.#texture.dispose();
    this.geometry.dispose();
    this.material.dispose();
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
    pen.setTransform(FINE / 1e3, 0, 0, FINE / 1e3, 0, 0);
    pen.clearRect(0, 0, WIDE, HIGH);
    pen.textBaseline = "alphabetic";
    pen.fillStyle = "rgba(22, 27, 33, 0.94)";
    box(pen, 0, 0, WIDE, HIGH, 12);
    const { title, lines, measures, progress, recording } = this.#content;
    pen.fillStyle = "#ffffff";
    pen.font = font(TITLE, 600);
    const room = WIDE - 2 * EDGE;
    pen.fillText(title, EDGE, 28, recording === null ? room : room - 100);
    if (recording !== null) drawRecording(pen, recording);
    let y = 50;
    pen.font = font(TEXT, 400);
    pen.fillStyle = "#d6dce2";
    for (const line of lines.flatMap((each) => wrapped(pen, each, room))) {
      pen.fillText(line, EDGE, y);
      y += 1.4 * TEXT;
    }
    measures.forEach((measure, k) => {
      drawMeasure(pen, measure, y - 0.4 * SMALL + 16.5 * k);
    });
    if (progress !== null) {
      const top = HIGH - 1e3 * BUTTON_HEIGHT - 1.9 * EDGE;
      pen.fillStyle = "#3a434d";
      box(pen, EDGE, top, room, 4, 2);
      pen.fillStyle = GOOD;
      box(pen, EDGE, top, room * Math.min(Math.max(progress, 0), 1), 4, 2);
    }
    this.#drawButtons(pen);
    this.#texture.needsUpdate = true;
  }

  #drawButtons(pen: CanvasRenderingContext2D): void {
    pen.textAlign = "center";
    pen.font = font(SMALL, 600);
    const [width, height] = [1e3 * this.#buttonWidth(), 1e3 * BUTTON_HEIGHT];
    for (const { label } of this.#content.buttons) {
      const middle = this.middleOf(label)!;
      const [x, y] = [1e3 * middle.x + WIDE / 2, HIGH / 2 - 1e3 * middle.y];
      pen.fillStyle = "#2f6fd0";
      box(pen, x - width / 2, y - height / 2, width, height, 7);
      pen.fillStyle = "#ffffff";
      pen.fillText(label, x, y + 0.36 * SMALL, width - 6);
    }
    pen.textAlign = "left";
  }
}

/** A bar that shrinks below a mark. */
function drawMeasure(
  pen: CanvasRenderingContext2D,
  { name, value, share }: Measure,
  y: number,
): void {
  const [from, width, limit] = [98, 150, 0.5]; // the mark is in the middle of the bar
  const filled = Math.min(1, limit * (Number.isFinite(share) ? share : 2));
  pen.font = font(SMALL, 400);
  pen.fillStyle = "#d6dce2";
  pen.fillText(name, EDGE, y + 0.36 * SMALL);
  pen.fillStyle = "#3a434d";
  box(pen, from, y - 3, width, 6, 3);
  pen.fillStyle = share <= 1 ? GOOD : POOR;
  box(pen, from, y - 3, Math.max(6, width * filled), 6, 3);
  pen.fillStyle = "#ffffff";
  pen.fillRect(from + limit * width - 0.6, y - 6, 1.2, 12);
  pen.fillStyle = share <= 1 ? GOOD : POOR;
  pen.fillText(value, from + width + 12, y + 0.36 * SMALL);
}

function drawRecording(pen: CanvasRenderingContext2D, participant: string): void {
  pen.fillStyle = RED;
  pen.beginPath();
  pen.arc(WIDE - 100, 23, 4.2, 0, 2 * Math.PI);
  pen.fill();
  pen.font = font(SMALL, 600);
  pen.fillText(`Recording ${participant}`, WIDE - 92, 26.5, 80);
}

function box(
  pen: CanvasRenderingContext2D,
  x: number,
  y: number,
  width: number,
  height: number,
  round: number,
): void {
  pen.beginPath();
  pen.roundRect(x, y, width, height, round);
  pen.fill();
}

/** Of a size in mm. */
function font(size: number, weight: number): string {
  return `${weight} ${size}px ${FONT}`;
}

function wrapped(pen: CanvasRenderingContext2D, text: string, width: number): string[] {
  const lines: string[] = [];
  for (const word of text.split(" ")) {
    const longer = lines.length ? `${lines.at(-1)} ${word}` : word;
    if (lines.length && pen.measureText(longer).width <= width) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}
