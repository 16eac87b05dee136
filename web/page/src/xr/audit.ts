import { inverse, Matrix } from "ml-matrix";
import { Vector3 } from "three";

/** One contact, and where the gap that was seen came from; metres, signed along the normal. */
export interface AuditedContact {
  readonly time: number;
  readonly hand: 0 | 1;
  readonly finger: number;
  /** What told of the contact: the finger stopped, or an outside signal. */
  readonly signal: "stopped" | "outside";
  /** Between the displayed skin and the virtual surface when the contact was told. */
  readonly gap: number;
  /** f on the prop's surface against the goal there. */
  readonly warp: number;
  /** What one common shift of the prop explains of it. */
  readonly calibration: number;
  /** What the settled finger keeps after that. */
  readonly tracking: number;
  /** What was gone once the finger had settled. */
  readonly latency: number;
}

/** What is known of a contact before it is taken apart; m, room frame. */
export interface SettledContact {
  readonly time: number;
  readonly hand: 0 | 1;
  readonly finger: number;
  readonly signal: "stopped" | "outside";
  /** The virtual surface's outward normal. */
  readonly normal: Vector3;
  /** Displayed skin above the virtual surface: at the contact, and when the finger had settled. */
  readonly gapAtContact: number;
  readonly gapSettled: number;
  readonly warp: number;
}

/** Contacts that the live figures are taken from. */
const WINDOW = 24;
/** One sigma of what tracking does to one touch, and of what calibration leaves, m, per axis. */
const TRACKING = 0.005;
const CALIBRATION = 0.004;

/**
 * Takes the gaps of contacts apart.
 *
 * A prop that is not where it was calibrated shows as gaps n·d with one d for all contacts, which is
 * what a new calibration would mend; d is the most likely one given Gaussian priors of both. What is
 * left of a gap is tracking's.
 */
export class TouchAudit {
  readonly contacts: AuditedContact[] = [];
  #recent: SettledContact[] = [];

  add(contact: SettledContact): AuditedContact {
    this.#recent = [...this.#recent.slice(1 - WINDOW), contact];
    const { gapAtContact, gapSettled, warp, normal, ...rest } = contact;
    const calibration = normal.dot(this.shift);
    const audited = {
      ...rest,
      gap: gapAtContact,
      warp,
      calibration,
      tracking: gapSettled - warp - calibration,
      latency: gapAtContact - gapSettled,
    };
    this.contacts.push(audited);
    return audited;
  }

  /** Forget what an old calibration did. */
  restart(): void {
    this.#recent = [];
    this.contacts.length = 0;
  }

  /** d: the shift of what is displayed that explains the recent gaps best, m. */
  get shift(): Vector3 {
    const left = Matrix.eye(3).mul(CALIBRATION ** -2);
    const right = Matrix.zeros(3, 1);
    for (const { normal, gapSettled, warp } of this.#recent) {
      const n = Matrix.columnVector(normal.toArray());
      left.add(n.mmul(n.transpose()).mul(TRACKING ** -2));
      right.add(Matrix.mul(n, (gapSettled - warp) * TRACKING ** -2));
    }
    const [x, y, z] = inverse(left).mmul(right).to1DArray();
    return new Vector3(x, y, z);
  }

  /** Medians over recent contacts of the sizes of the gap and of its causes, m; null before any. */
  get medians() {
    const recent = this.contacts.slice(-WINDOW);
    if (recent.length === 0) return null;
    const of = (name: "gap" | "warp" | "calibration" | "tracking" | "latency") => {
      const sizes = recent.map((contact) => Math.abs(contact[name]));
      return sizes.sort((one, other) => one - other)[sizes.length >> 1]!;
    };
    return {
      gap: of("gap"),
      warp: of("warp"),
      calibration: of("calibration"),
      tracking: of("tracking"),
      latency: of("latency"),
    };
  }

  /** "7 mm: 5 tracker, 2 calibration, 0.4 latency, 0.02 warp". */
  get line(): string {
    const medians = this.medians;
    if (!medians) return "no contact yet";
    const causes: [string, number][] = [
      ["tracker", medians.tracking],
      ["calibration", medians.calibration],
      ["latency", medians.latency],
      ["warp", medians.warp],
    ];
    causes.sort(([, one], [, other]) => other - one);
    const parts = causes.map(([name, size]) => `${inMm(size)} ${name}`);
    return `${inMm(medians.gap)} mm: ${parts.join(", ")}`;
  }

  /** Whether the prop seems to have moved since it was calibrated: time to do it again. */
  get hasDrifted(): boolean {
    return this.#recent.length >= 8 && this.shift.length() > 0.006;
  }
}

function inMm(size: number): string {
  const millimetres = 1000 * size;
  return millimetres.toFixed(millimetres < 0.095 ? 2 : millimetres < 0.95 ? 1 : 0);
}

/** How slow a finger that has stopped is, m/s, and how fast one that comes, and for how long. */
const STOPPED = 0.03;
const COMING = 0.06;
const SETTLE = 0.15;

/** Finds contacts in the motion of one fingertip: it comes, is near the surface, and stops. */
export class StopDetector {
  #last: { time: number; skin: Vector3 } | null = null;
  #came = -Infinity;
  #contact: { time: number; gap: number } | null = null;

  /**
   * @param skin the tracked skin nearest to the prop, m; NaN when lost
   * @param nearness its distance from the prop's surface, m
   * @param gap of the displayed skin from the virtual surface, m
   * @returns the contact, once it has settled
   */
  update(
    time: number,
    skin: Vector3,
    nearness: number,
    gap: number,
  ): { time: number; gapAtContact: number; gapSettled: number } | null {
    const before = this.#last;
    if (!Number.isFinite(skin.x)) {
      this.#last = this.#contact = null;
      return null;
    }
    this.#last = { time, skin: skin.clone() };
    if (before === null || time <= before.time) return null;
    const speed = skin.distanceTo(before.skin) / (time - before.time);
    if (Math.abs(nearness) > 0.025) {
      this.#contact = null;
      if (speed > COMING) this.#came = time;
      return null;
    }
    if (speed > COMING) this.#came = time;
    if (this.#contact === null) {
      if (speed < STOPPED && time - this.#came < 0.5) this.#contact = { time, gap };
      return null;
    }
    if (time - this.#contact.time < SETTLE) return null;
    const { time: begun, gap: gapAtContact } = this.#contact;
    this.#contact = null;
    this.#came = -Infinity;
    return { time: begun, gapAtContact, gapSettled: gap };
  }
}
