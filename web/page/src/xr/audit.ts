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

/** What a gap is shared out to. */
export type Cause = "warp" | "calibration" | "tracking" | "latency";

/** What is known of a contact before it is taken apart; m, scene frame. */
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
const CALIBRATION = 0.008;
/** Nobody touches more alike than this, m. */
const LEAST_TRACKING = 0.003;
/** A touch that misses by more than this times its sigma was something else: it counts little. */
const ODD = 1.5;
const ROUNDS = 8;
/** A shift that asks for another calibration: as long as this, m, by so many contacts, and one that
 * chance gives to less than a hundredth of those whose prop stands still. */
const DRIFTED = 0.006;
const LEAST_CONTACTS = 8;
const SURPRISING = 13;

/**
 * Takes the gaps of contacts apart.
 *
 * A prop that is not where it was calibrated shows as gaps n·d with one d for all contacts, which is
 * what a new calibration would mend; d is the most likely one given a Gaussian prior of d and tracking
 * whose errors have long tails (Cauchy's). What is left of a gap is tracking's.
 */
export class TouchAudit {
  readonly contacts: AuditedContact[] = [];
  /** d: the shift of what is displayed that explains the recent gaps best, m. */
  shift = new Vector3();
  /** d over its own uncertainty, squared (χ² of three freedoms if the prop has not moved). */
  #surprise = 0;
  #recent: SettledContact[] = [];

  add(contact: SettledContact): AuditedContact {
    this.#recent = [...this.#recent.slice(1 - WINDOW), contact];
    [this.shift, this.#surprise] = commonShift(this.#recent);
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
    this.shift = new Vector3();
    this.#surprise = 0;
  }

  /**
   * The size of a typical recent gap and the signed shares of its causes, m; null before any contact.
   *
   * Means over the middle half of the contacts by size. A share counts along its contact's gap, so the
   * shares add up to the size; one below zero made gaps smaller than they would have been.
   */
  get typical(): Record<"gap" | Cause, number> | null {
    const recent = this.contacts.slice(-WINDOW);
    if (recent.length === 0) return null;
    recent.sort((one, other) => Math.abs(one.gap) - Math.abs(other.gap));
    const tail = Math.floor(recent.length / 4);
    const middle = recent.slice(tail, recent.length - tail);
    const mean = (name: "gap" | Cause) => {
      const along = middle.map((contact) => Math.sign(contact.gap) * contact[name]);
      return along.reduce((sum, share) => sum + share, 0) / middle.length;
    };
    return {
      gap: mean("gap"),
      warp: mean("warp"),
      calibration: mean("calibration"),
      tracking: mean("tracking"),
      latency: mean("latency"),
    };
  }

  /** "Gap 7.4 mm: 5.0 tracker, 2.0 calibration, 0.4 latency, 0.02 warp". */
  get line(): string {
    const { typical } = this;
    if (!typical) return "No contact yet.";
    const causes: [string, number][] = [
      ["tracker", typical.tracking],
      ["calibration", typical.calibration],
      ["latency", typical.latency],
      ["warp", typical.warp],
    ];
    causes.sort(([, one], [, other]) => Math.abs(other) - Math.abs(one));
    const parts = causes.map(([name, size]) => `${inMm(size)} ${name}`);
    return `Gap ${inMm(typical.gap)} mm: ${parts.join(", ")}`;
  }

  /** Whether the prop seems to have moved since it was calibrated: time to do it again. */
  get hasDrifted(): boolean {
    const enough = this.#recent.length >= LEAST_CONTACTS;
    return enough && this.shift.length() > DRIFTED && this.#surprise > SURPRISING;
  }
}

/** d by iteratively reweighted least squares, and its size over its uncertainty, squared. */
function commonShift(contacts: readonly SettledContact[]): [Vector3, number] {
  let shift = new Vector3();
  let left = Matrix.zeros(3, 3);
  const missed = ({ normal, gapSettled, warp }: SettledContact) =>
    gapSettled - warp - normal.dot(shift);
  for (let round = 0; round < ROUNDS; round++) {
    left = Matrix.eye(3).mul(CALIBRATION ** -2);
    const right = Matrix.zeros(3, 1);
    for (const contact of contacts) {
      const odd = round === 0 ? 0 : missed(contact) / (ODD * TRACKING);
      const weight = TRACKING ** -2 / (1 + odd * odd);
      const n = Matrix.columnVector(contact.normal.toArray());
      left.add(n.mmul(n.transpose()).mul(weight));
      right.add(Matrix.mul(n, (contact.gapSettled - contact.warp) * weight));
    }
    shift = new Vector3(...inverse(left).mmul(right).to1DArray());
  }
  const sizes = contacts.map((contact) => Math.abs(missed(contact))).sort((a, b) => a - b);
  const sigma = Math.max(1.4826 * sizes[sizes.length >> 1]!, LEAST_TRACKING);
  const d = Matrix.columnVector(shift.toArray());
  const surprise = d.transpose().mmul(left).mmul(d).get(0, 0) * (TRACKING / sigma) ** 2;
  return [shift, surprise];
}

/** Two digits at least below 10 mm, so that the shares still add up when they are read. */
function inMm(size: number): string {
  const millimetres = Math.abs(1000 * size);
  const digits = millimetres < 0.095 ? 2 : millimetres < 9.95 ? 1 : 0;
  const told = millimetres.toFixed(digits);
  return size < 0 && Number(told) > 0 ? `−${told}` : told;
}

/** A finger that stops farther from the surface than this, m, has not touched it. */
export const TOUCHED = 0.01;

/** How slow a finger that has stopped is, m/s, and how fast one that comes, and for how long. */
const STOPPED = 0.03;
const COMING = 0.06;
const SETTLE = 0.15;

/** Finds contacts in the motion of one fingertip: it comes, is near the surface, and stops. */
export class StopDetector {
  #last: { time: number; skin: Vector3 } | null = null;
  #came = -Infinity;
  #contact: { time: number; gap: number } | null = null;

  /** The contact that is settling has been told of by something else. */
  forget(): void {
    this.#contact = null;
    this.#came = -Infinity;
  }

  /**
   * @param skin the tracked skin nearest to the prop, m; NaN when lost
   * @param nearness its distance from the prop's surface, m
   * @param gap of the displayed skin from the virtual surface, m
   * @param leads whether no other fingertip of the hand is nearer: the others stop because it does
   * @returns the contact, once it has settled
   */
  update(
    time: number,
    skin: Vector3,
    nearness: number,
    gap: number,
    leads = true,
  ): { time: number; gapAtContact: number; gapSettled: number } | null {
    const before = this.#last;
    if (!Number.isFinite(skin.x)) {
      this.#last = this.#contact = null;
      return null;
    }
    this.#last = { time, skin: skin.clone() };
    if (before === null || time <= before.time) return null;
    const speed = skin.distanceTo(before.skin) / (time - before.time);
    if (Math.abs(nearness) > TOUCHED) {
      this.#contact = null;
      if (speed > COMING) this.#came = time;
      return null;
    }
    if (speed > COMING) this.#came = time;
    if (this.#contact === null) {
      const stops = speed < STOPPED && time - this.#came < 0.5;
      if (stops && leads) this.#contact = { time, gap };
      return null;
    }
    if (time - this.#contact.time < SETTLE) return null;
    const { time: begun, gap: gapAtContact } = this.#contact;
    this.forget();
    return { time: begun, gapAtContact, gapSettled: gap };
  }
}
