import type { Calibration, Doubt } from "../calibrate/assess.js";
import type { Calibrator } from "./calibrator.js";
import type { Session } from "./session.js";

const DOUBTS: Record<Doubt, string> = {
  "too few touches": "Not enough touches yet: go on.",
  place: "Its place is not sure yet.",
  turn: "Its turn is not sure yet.",
  ambiguous: "Several places would fit: touch another side.",
};

/** What to tell the person, line by line. */
export function instruct(
  session: Session,
  calibrator: Calibrator,
  facts: { readonly audit: string; readonly drifted: boolean; readonly notice: string },
): { title: string; lines: string[]; progress: number | null } {
  const name = calibrator.prop.state.name;
  const trouble = session.trouble ? [session.trouble] : [];
  if (session.pauses.has("outside")) {
    return plain("Paused: come back", ["You have left the place where the prop stands."]);
  }
  if (session.pauses.size > 0) {
    return plain("Paused", ["This is the real room. Poke Resume to go on."]);
  }
  switch (session.phase) {
    case "preflight":
      return plain("One moment", ["The scene is being loaded.", facts.notice]);
    case "calibrate":
      return {
        title: `Where is the ${name}?`,
        lines: [...trouble, ...calibrationLines(calibrator)],
        progress: null,
      };
    case "resolve":
      return plain("Solving", ["The props stand elsewhere than in the scene.", facts.notice]);
    case "verify":
      return {
        title: `Touch the ${name} in ${calibrator.touchesLeft} more places`,
        lines: [
          ...trouble,
          "Put an index fingertip on it, pinch with the other hand,",
          "wait a moment, let go. Each time at another place.",
          facts.notice,
        ],
        progress: calibrator.touches.length / 5,
      };
    case "immersed":
      return plain(facts.drifted ? "Has the prop moved?" : "Touch what you see", [
        facts.audit,
        facts.drifted ? "Touches have drifted: poke Redo to calibrate again." : facts.notice,
        "Both hands above your eyes bring the real room back.",
      ]);
    case "ended":
      return plain("", []);
  }
}

function plain(title: string, lines: string[]) {
  return { title, lines, progress: null };
}

function calibrationLines({ calibration, strokeLength }: Calibrator): string[] {
  const how = [
    "Pinch and hold with one hand; with the other index fingertip",
    "rub all over it: sides, rim, handle. Let go to end a stroke.",
  ];
  if (strokeLength > 0) return ["Rubbing: keep the fingertip on it …", ...how];
  if (!calibration) return how;
  return [
    ...calibration.doubts.map((doubt) => DOUBTS[doubt]),
    uncertaintyLine(calibration),
    "Next: rub around the ring, or touch it and stay there.",
  ];
}

/** "Known to ±3 mm across, ±2 mm in height, ±4° of turn." */
export function uncertaintyLine({ translation95, turn95 }: Calibration): string {
  const across = Math.max(translation95.x, translation95.z);
  const millimetres = (size: number) =>
    size > 0.1 ? "not known" : `±${(1000 * size).toFixed(size < 0.0095 ? 1 : 0)} mm`;
  const turn =
    turn95 > Math.PI / 2 ? "turn free" : `±${((180 / Math.PI) * turn95).toFixed(0)}° turn`;
  return `Across ${millimetres(across)}, height ${millimetres(translation95.y)}, ${turn} (95 %).`;
}
