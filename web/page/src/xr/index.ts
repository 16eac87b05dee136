import "./xr.css";
import type { Context } from "../context.js";
import { Experience } from "./experience.js";
import { tellHow } from "./how_to.js";
import { askPreflight } from "./preflight.js";

const FEATURES: XRSessionInit = {
  requiredFeatures: ["local-floor", "hand-tracking"],
  optionalFeatures: ["anchors", "bounded-floor"],
};

/** The desk's drawing, which rests while the headset's goes on. */
interface Pausable {
  paused: boolean;
}

/** Offer the headset where the browser has one that tracks hands, and elsewhere tell how to get there. */
export async function mountXr(context: Context, desk: Pausable): Promise<void> {
  const slot = document.querySelector<HTMLElement>("#xr-slot")!;
  const mode = await bestMode();
  const status = document.createElement("span");
  status.id = "xr-status";
  status.setAttribute("role", "status");
  const button = document.createElement("button");
  slot.append(status, button);
  if (mode === null) {
    button.textContent = "Headset …";
    button.name = "how-to-headset";
    button.addEventListener("click", () => tellHow(context.state));
    return;
  }
  button.id = "enter-xr";
  button.className = "main";
  button.textContent = "Enter the headset";
  button.addEventListener("click", async () => {
    const choices = await askPreflight(mode === "immersive-ar", context.state.props.length);
    if (choices === null) return;
    status.textContent = "";
    button.disabled = desk.paused = true;
    const free = () => {
      button.disabled = desk.paused = false;
    };
    let session: XRSession | null = null;
    try {
      session = await navigator.xr!.requestSession(mode, FEATURES);
      await new Experience(context, session, choices, free).start();
    } catch (error) {
      await session?.end().catch(() => {}); // it may have ended by itself
      free();
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
