import { type Quaternion, Vector3 } from "three";

/** A place on the prop that the person was asked to touch, prop frame. */
export interface NamedPoint {
  readonly point: Vector3;
  /** Outward unit normal. */
  readonly normal: Vector3;
}

/** One tracked sample of a fingertip that rests on the prop; room frame, metres, seconds. */
export interface Contact {
  /** Centre of the fingertip joint. */
  readonly tip: Vector3;
  /** Turn of the fingertip joint: hand-fixed bias turns along with it. */
  readonly turn: Quaternion;
  /** From the centre to the skin. */
  readonly radius: number;
  readonly time: number;
  /** Where on the prop, if the person was asked for a certain place; absent for free rubbing. */
  readonly named?: NamedPoint;
}

/** One standard deviation of what tracking does to a fingertip: metres, per axis. */
export interface TrackingModel {
  /** An offset that is constant in the room. It moves prop and hand alike, so contact survives it. */
  readonly roomBias: number;
  /** An offset that is constant in the fingertip's own frame. */
  readonly handBias: number;
  /** Least noise to believe in, however small the residual. */
  readonly noiseFloor: number;
  /** Over how many seconds the noise forgets itself. */
  readonly correlationTime: number;
  /** How far beside a named place people touch. */
  readonly pointing: number;
}

/** A headset's own hand tracking: about 10 mm of bias, noise that lasts for half a second. */
export const HEADSET_HANDS: TrackingModel = {
  roomBias: 0.006,
  handBias: 0.006,
  noiseFloor: 0.0003,
  correlationTime: 0.5,
  pointing: 0.006,
};

/** One run of samples between putting the fingertip on the prop and lifting it. */
export type Stroke = readonly Contact[];

/**
 * The samples that can be trusted to be on the prop.
 *
 * Tracking lags behind the signal that marks a stroke, so a stroke begins with samples of the
 * approach and may miss the lift; `margin` seconds (the lag and a little) go at both ends. Samples
 * with a lost joint go too.
 */
export function trimStrokes(strokes: readonly Stroke[], margin = 0.1): Contact[] {
  return strokes.flatMap((stroke) => {
    const first = stroke[0];
    const last = stroke[stroke.length - 1];
    if (!first || !last) return [];
    return stroke.filter(
      ({ tip, time, named }) =>
        Number.isFinite(tip.x + tip.y + tip.z) &&
        (named !== undefined || (time >= first.time + margin && time <= last.time - margin)),
    );
  });
}

/** One contact from the samples of a finger that dwells at a named place: their middle. */
export function namedTouch(samples: Stroke, named: NamedPoint): Contact | null {
  const seen = samples.filter(({ tip }) => Number.isFinite(tip.x + tip.y + tip.z));
  const middle = seen[seen.length >> 1];
  if (!middle) return null;
  const along = (axis: number) => median(seen.map(({ tip }) => tip.getComponent(axis)));
  return { ...middle, tip: new Vector3(along(0), along(1), along(2)), named };
}

function median(values: number[]): number {
  return values.sort((one, other) => one - other)[values.length >> 1]!;
}

/** At most `count` of the contacts, evenly spread over their order; named ones all stay. */
export function thinContacts(contacts: readonly Contact[], count: number): Contact[] {
  const named = contacts.filter((contact) => contact.named);
  const free = contacts.filter((contact) => !contact.named);
  if (free.length <= count) return [...named, ...free];
  const step = free.length / count;
  return [
    ...named,
    ...Array.from({ length: count }, (_, k) => free[Math.floor((k + 0.5) * step)]!),
  ];
}

/** How many samples with independent noise the contacts are worth, N² / ΣΣ exp(−|Δt| / τ). */
export function effectiveCount(contacts: readonly Contact[], tracking: TrackingModel): number {
  const known = counts.get(contacts);
  if (known !== undefined) return known;
  let sum = 0;
  for (const { time } of contacts) {
    for (const other of contacts)
      sum += Math.exp(-Math.abs(time - other.time) / tracking.correlationTime);
  }
  const count = sum > 0 ? contacts.length ** 2 / sum : 0;
  counts.set(contacts, count);
  return count;
}

const counts = new WeakMap<readonly Contact[], number>();
