import type { Experience } from "./experience.js";
import type { Button } from "./panel.js";
import type { SessionEvent } from "./session.js";

/** What a person can do from the panel. */
export function buttonsOf(experience: Experience): Button[] {
  const { session, way, showsGhosts, warning, xr } = experience;
  const { recorder } = experience.context;
  const tells = (event: SessionEvent) => () => experience.tell(event);
  const buttons: Button[] = [
    session.pauses.has("asked")
      ? { label: "Resume", press: tells({ kind: "resume", pause: "asked" }) }
      : { label: "Pause", press: tells({ kind: "pause", pause: "asked" }) },
    { label: "Redo", press: tells({ kind: "redo" }) },
    { label: "Recentre", press: () => experience.recentre() },
  ];
  if (warning.length > 0) {
    const understood = () => {
      experience.warning = [];
    };
    buttons.push({ label: "Understood", press: understood });
  } else if (session.phase === "calibrate") {
    const other = way === "rub" ? "places" : "rub";
    const label = other === "rub" ? "By rubbing" : "By places";
    buttons.push({ label, press: () => experience.goBy(other) });
  } else {
    const toggle = () => {
      experience.showsGhosts = !showsGhosts;
    };
    buttons.push({ label: showsGhosts ? "Hide real" : "Show real", press: toggle });
  }
  if (recorder.recording) buttons.push({ label: "Stop rec.", press: () => recorder.end() });
  return [...buttons, { label: "Leave", press: () => void xr.end() }];
}
