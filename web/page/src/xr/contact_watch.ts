import { Quaternion, Vector3 } from "three";
import type { Warp } from "touchwarp";
import { type DisplayedHand, TIPS } from "../world/displayed_hand.js";
import { type AuditedContact, StopDetector, TOUCHED, TouchAudit } from "./audit.js";
import type { HandInput } from "./hand_input.js";
import type { PlacedProps } from "./prop_model.js";

/** Nearer than this to the prop, a fingertip's skin counts as on it, m. */
const ON_SURFACE = 0.003;
/** A finger that is not on the prop within this after an outside signal did not cause it, s. */
const SIGNAL_LASTS = 0.1;

/** Watches all ten fingertips for contacts, and audits them. */
export class ContactWatch {
  readonly audit = new TouchAudit();
  /** Contacts of the last update. */
  fresh: AuditedContact[] = [];
  #detectors = Array.from({ length: 10 }, () => new StopDetector());
  #outside: number | null = null;

  restart(): void {
    this.audit.restart();
  }

  /** An outside signal (a touch sensor on the prop, say) tells of a contact at `time`, s. */
  signal(time: number): void {
    this.#outside = time;
  }

  /**
   * One hand at one frame.
   * @returns which fingertips are on the prop: bit 0 the thumb … bit 4 the little finger
   */
  update(
    time: number,
    input: HandInput,
    displayed: DisplayedHand,
    placed: PlacedProps,
    warp: Warp | null,
  ): number {
    this.fresh = [];
    if (this.#outside !== null && time - this.#outside > SIGNAL_LASTS) this.#outside = null;
    if (!input.tracked || placed.props.length === 0) return 0;
    const { gaps, normals } = displayed;
    let least = Number.POSITIVE_INFINITY;
    for (const nearness of gaps) if (Math.abs(nearness) < least) least = Math.abs(nearness);
    let touching = 0;
    for (let finger = 0; finger < 5; finger++) {
      const nearness = gaps[finger]!;
      if (Number.isNaN(nearness)) continue;
      const joint = TIPS[finger]!;
      const radius = input.radius(joint);
      const leads = Math.abs(nearness) === least;
      if (Math.abs(nearness) < ON_SURFACE) touching |= 1 << finger;
      shown.fromArray(displayed.poses, 16 * joint + 12);
      // farther away nobody asks for the gap, and looking it up takes its time
      const near = Math.abs(nearness) <= TOUCHED;
      const tip = 5 * input.side + finger;
      const gap = near ? placed.seen(tip, shown, outward) - radius : Number.NaN;
      input.joint(joint, real);
      skin.copy(real).addScaledVector(normal.fromArray(normals, 3 * finger), -radius);
      const detector = this.#detectors[tip]!;
      const stop = detector.update(time, skin, nearness, gap, leads);
      if (!warp || !displayed.claims(finger)) continue;
      const told = this.#outside !== null && leads && touching & (1 << finger);
      if (!stop && !told) continue;
      if (told) detector.forget(); // the same contact is not to be told again once it has settled
      const felt = placed.felt(real);
      felt.point.toArray(place);
      warp.displayed(place, place);
      this.fresh.push(
        this.audit.add({
          time: stop?.time ?? this.#outside ?? time,
          hand: input.side,
          finger,
          signal: stop ? "stopped" : "outside",
          // a prop that is carried takes its shift along
          normal: outward.clone().applyQuaternion(unturned.copy(placed.pose.turn).invert()),
          gapAtContact: stop?.gapAtContact ?? gap,
          gapSettled: stop?.gapSettled ?? gap,
          warp: skin.fromArray(place).sub(felt.goal).dot(outward),
        }),
      );
      this.#outside = null;
    }
    return touching;
  }
}

const real = new Vector3();
const shown = new Vector3();
const skin = new Vector3();
const normal = new Vector3();
const outward = new Vector3();
const unturned = new Quaternion();
const place = new Float64Array(3);
