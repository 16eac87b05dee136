/**
 * What a session in the headset is doing, apart from how it looks: a pure machine.
 *
 *     preflight → calibrate (each prop) → resolve (several props) → verify (each) → immersed
 *
 * Pauses lie over a phase and leave it as it is. Hands are displaced in `immersed` only, and only
 * without a pause.
 */
export type Phase = "preflight" | "calibrate" | "resolve" | "verify" | "immersed" | "ended";

/** Why a session is paused: by the person's wish or gesture, for safety, or since there is no warp
 * yet for the scene as it now is. */
export type Pause = "asked" | "hidden" | "outside" | "unready";

export interface Session {
  readonly phase: Phase;
  /** How many props are calibrated one after another. */
  readonly props: number;
  /** The prop that is calibrated or verified now. */
  readonly prop: number;
  readonly pauses: ReadonlySet<Pause>;
  /** The room's origin has jumped: what was calibrated must be verified again. */
  readonly doubted: boolean;
  /** Why the last step did not succeed, for the person. */
  readonly trouble: string | null;
}

export type SessionEvent =
  | { readonly kind: "ready" }
  | { readonly kind: "calibrated" }
  | { readonly kind: "resolved" }
  | { readonly kind: "unresolved"; readonly reason: string }
  | { readonly kind: "verified" }
  | { readonly kind: "missed"; readonly reason: string }
  | { readonly kind: "redo" }
  | { readonly kind: "pause"; readonly pause: Pause }
  | { readonly kind: "resume"; readonly pause: Pause }
  | { readonly kind: "origin moved" }
  | { readonly kind: "end" };

export function begin(props: number): Session {
  return {
    phase: "preflight",
    props,
    prop: 0,
    pauses: new Set(),
    doubted: false,
    trouble: null,
  };
}

/** The session after an event; events that do not belong to the phase change nothing. */
export function advance(session: Session, event: SessionEvent): Session {
  const { phase, prop, props } = session;
  if (phase === "ended") return session;
  const goes = (change: Partial<Session>): Session => ({ ...session, trouble: null, ...change });
  const isLast = prop === props - 1;
  switch (event.kind) {
    case "ready":
      return phase === "preflight" ? goes({ phase: "calibrate", prop: 0 }) : session;
    case "calibrated":
      if (phase !== "calibrate") return session;
      if (!isLast) return goes({ prop: prop + 1 });
      return goes({ phase: props > 1 ? "resolve" : "verify", prop: 0 });
    case "resolved":
      return phase === "resolve" ? goes({ phase: "verify", prop: 0 }) : session;
    case "unresolved":
      if (phase !== "resolve") return session;
      return goes({ phase: "calibrate", prop: 0, trouble: event.reason });
    case "verified":
      if (phase !== "verify") return session;
      return isLast ? goes({ phase: "immersed", doubted: false }) : goes({ prop: prop + 1 });
    case "missed":
      if (phase !== "verify") return session;
      return goes({ phase: "calibrate", prop: 0, trouble: event.reason });
    case "redo":
      return phase === "preflight" ? session : goes({ phase: "calibrate", prop: 0 });
    case "pause":
      return { ...session, pauses: new Set([...session.pauses, event.pause]) };
    case "resume":
      return {
        ...session,
        pauses: new Set([...session.pauses].filter((pause) => pause !== event.pause)),
      };
    case "origin moved":
      if (phase !== "verify" && phase !== "immersed") return session;
      return goes({
        phase: "verify",
        prop: 0,
        doubted: true,
        trouble: "The headset has moved its origin: please touch the prop again.",
      });
    case "end":
      return goes({ phase: "ended", pauses: new Set() });
  }
}

/** Whether displayed hands may differ from the tracked ones. */
export function isDisplaced({ phase, pauses }: Session): boolean {
  return phase === "immersed" && pauses.size === 0;
}

/** How much of the virtual world is to be seen, 0 or 1: what it fades towards. */
export function worldGoal(session: Session): 0 | 1 {
  return isDisplaced(session) ? 1 : 0;
}

/** `value`, moved towards `goal` by no more than the share of `seconds` that has passed. */
export function fade(value: number, goal: number, elapsed: number, seconds: number): number {
  const most = elapsed / seconds;
  return value + Math.min(Math.max(goal - value, -most), most);
}
