import "./xr.css";
import type { Context } from "../context.js";
import { Experience } from "./experience.js";
import { askPreflight } from "./preflight.js";

const FEATURES: XRSessionInit = {
  requiredFeatures: ["local-floor", "hand-tracking"],
  optionalFeatures: ["anchors", "bounded-floor"],
};

/** The desk's drawing, which rests while the headset's goes on. */
interface Pausable {
  paused: boolean;
}

/** Offer the headset where the browser has one that tracks hands. */
export async function mountXr(context: Context, desk: Pausable): Promise<void> {
  const slot = document.querySelector<HTMLElement>("#xr-slot")!;
  const mode = await bestMode();
  if (mode === null) {
    slot.title = "No headset here: open this page in a headset's browser.";
    return;
  }
  const status = document.createElement("span");
  status.id = "xr-status";
  const button = document.createElement("button");
  button.id = "enter-xr";
  button.textContent = "Enter the headset";
  slot.append(status, button);
  button.addEventListener("click", async () => {
    const choices = await askPreflight(mode === "immersive-ar");
    if (choices === null) return;
    try {
      status.textContent = "";
      const session = await navigator.xr!.requestSession(mode, FEATURES);
      button.disabled = desk.paused = true;
      const experience = new Experience(context, session, choices, () => {
        button.disabled = desk.paused = false;
      });
      await experience.start();
    } catch (error) {
      button.disabled = desk.paused = false;
      const reason = error instanceof Error ? error.message : String(error);
      status.textContent = `The headset cannot be used: ${reason}`;
    }
  });
}

/** One session that blends with the real room, else a plain virtual one, else none. */
async function bestMode(): Promise<"immersive-ar" | "immersive-vr" | null> {
  for (const mode of ["immersive-ar", "immersive-vr"] as const) {
    if (await navigator.xr?.isSessionSupported(mode).catch(() => false)) return mode;
  }
  return null;
}
