import type { Calibration, Doubt, Limits } from "../calibrate/assess.js";
import { LIMITS } from "../calibrate/assess.js";
import type { Calibrator } from "./calibrator.js";
import type { Carried } from "./carrier.js";
import type { Measure } from "./panel.js";
import type { Session } from "./session.js";

/** What the measures do not show by themselves. */
const DOUBTS: Partial<Record<Doubt, string>> = {
  "too few touches": "Not enough touches yet: go on.",
  ambiguous: "Several places would fit: touch another side.",
};

/** What the panel says. */
export interface Instruction {
  readonly title: string;
  readonly lines: readonly string[];
  readonly measures: readonly Measure[];
  /** 0 to 1; null for none. */
  readonly progress: number | null;
}

/** What there is to tell besides the session itself. */
export interface Facts {
  readonly audit: string;
  readonly drifted: boolean;
  readonly notice: string;
  /** To be read before anything else. */
  readonly warning: readonly string[];
  /** Whether the device shows the real room. */
  readonly seesRoom: boolean;
  /** Where the prop has been carried to, if the warp does not hold there. */
  readonly carried: Carried | "lost" | null;
  readonly solving: { readonly step: string; readonly progress: number | null };
}

/** What to tell the person. */
export function instruct(session: Session, calibrator: Calibrator, facts: Facts): Instruction {
  const name = calibrator.prop.state.name;
  const trouble = session.trouble ? [session.trouble] : [];
  const { pauses } = session;
  if (pauses.has("outside")) {
    return plain("Paused: come back", ["You have left the place where the prop stands."]);
  }
  if (pauses.has("asked") || pauses.has("hidden")) {
    const where = facts.seesRoom ? "This is the real room." : "Hands are shown where they are.";
    return plain("Paused", [`${where} Poke Resume to go on.`]);
  }
  if (pauses.has("unready") && session.phase === "immersed") {
    return plain("One moment", ["The scene is being prepared; hands are shown as they are."]);
  }
  if (facts.warning.length > 0) return plain("Careful", [...facts.warning]);
  switch (session.phase) {
    case "preflight":
      return plain("One moment", ["The scene is being loaded.", facts.notice]);
    case "calibrate":
      return {
        title: `Where is the ${name}?`,
        lines: [...trouble, ...calibrationLines(calibrator)],
        measures: calibrator.calibration ? measuresOf(calibrator.calibration) : [],
        progress: null,
      };
    case "resolve":
      return {
        title: "Solving for where they stand",
        lines: ["The props stand elsewhere than in the scene.", facts.solving.step],
        measures: [],
        progress: facts.solving.progress,
      };
    case "verify":
      return {
        title: `Touch the ${name} in ${places(calibrator.touchesLeft)}`,
        lines: [
          ...trouble,
          "Index fingertip on it, pinch with the other hand, wait a moment, let go. Each time at another place.",
          facts.notice,
        ],
        measures: [],
        progress: calibrator.touches.length / 5,
      };
    case "immersed":
      if (facts.carried === "lost") {
        return plain(`The ${name} is lost`, [
          "The controller that is fixed to it is not tracked; hands are shown where they are.",
        ]);
      }
      if (facts.carried) {
        const { shift, turn } = facts.carried;
        const degrees = ((180 / Math.PI) * turn).toFixed(1);
        return plain(`Put the ${name} back`, [
          `It is ${(1000 * shift).toFixed(0)} mm and ${degrees}° from where the scene was solved; what else is in the scene does not go along, so hands are shown where they are.`,
        ]);
      }
      return plain(facts.drifted ? "Has the prop moved?" : "Touch what you see", [
        facts.audit,
        facts.drifted ? "Touches have drifted: poke Redo to calibrate again." : facts.notice,
        facts.seesRoom
          ? "Both hands above your eyes bring the real room back."
          : "Both hands above your eyes stop all displacement.",
      ]);
    case "ended":
      return plain("", []);
  }
}

function plain(title: string, lines: string[]): Instruction {
  return { title, lines, measures: [], progress: null };
}

function calibrationLines(calibrator: Calibrator): string[] {
  const { calibration, strokeLength, way, busy } = calibrator;
  if (strokeLength > 0) {
    return [
      way === "rub"
        ? "Rubbing: keep the fingertip on it …"
        : "Keep the fingertip there a moment, then let go.",
    ];
  }
  const how =
    way === "rub"
      ? "Pinch and hold with one hand; with the other index fingertip rub all over it: sides, rim, handle. Let go to end a stroke."
      : "Put an index fingertip on the place that the model shows; pinch with the other hand, wait a moment, let go.";
  if (busy) return ["Working out where it stands …"];
  if (!calibration) return [how];
  return [
    ...calibration.doubts.flatMap((doubt) => DOUBTS[doubt] ?? []),
    way === "rub"
      ? "Next: rub around the ring, or touch it and stay there."
      : "Next: touch the ring.",
  ];
}

/** Each freedom with its 95 % half width, and whether that will do. */
export function measuresOf(
  { translation95, turns95 }: Calibration,
  limits: Limits = LIMITS,
): Measure[] {
  const lengths = [
    ["left–right", translation95.x],
    ["near–far", translation95.z],
    ["height", translation95.y],
  ] as const;
  const [first, upright, last] = turns95 as [number, number?, number?];
  const turns: [string, number][] =
    upright === undefined || last === undefined
      ? [["turn", first]]
      : [
          ["turn", upright],
          ["tilt near–far", first],
          ["tilt left–right", last],
        ];
  return [
    ...lengths.map(([name, half]) => ({
      name,
      value: half > 0.1 ? "not known" : `±${rounded(1000 * half, half < 0.0095 ? 1 : 0)} mm`,
      share: half / limits.translation,
    })),
    ...turns.map(([name, half]) => ({
      name,
      value: half > Math.PI / 2 ? "free" : `±${rounded((180 / Math.PI) * half, 0)}°`,
      share: half / limits.turn,
    })),
  ];
}

function places(count: number): string {
  return count === 1 ? "one more place" : `${count} more places`;
}

/** Up, so that what is shown holds no less than what was found. */
function rounded(value: number, digits: number): string {
  return (Math.ceil(value * 10 ** digits - 1e-6) / 10 ** digits).toFixed(digits);
}
