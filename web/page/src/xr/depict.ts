import { Matrix4, Vector3 } from "three";
import { buttonsOf } from "./controls.js";
import type { Experience } from "./experience.js";
import { type Facts, instruct } from "./words.js";

/** Put everything in the room where it belongs at this frame. */
export function depict(experience: Experience, time: number): void {
  const { room, session, world, seesRoom, placed } = experience;
  room.surroundings.show(seesRoom ? world : 1, world);
  room.surroundings.lookAround(placed.pose.place);
  room.carried.matrix.copy(placed.pose.matrix(matrix));
  // tables stay where they are when a prop is carried
  const rest = experience.carrier?.rest ?? placed.pose;
  room.tables.matrix.copy(room.carried.matrix).invert().multiply(rest.matrix(matrix));
  room.tables.visible = world > 0.3;
  const calibrating = session.phase === "calibrate" || session.phase === "verify";
  experience.calibrators.forEach(({ prop, calibration }, k) => {
    prop.ghost.visible = calibrating && calibration !== null && k === session.prop;
    prop.virtualObject.visible = world > 0.3;
  });
  depictHands(experience);
  guide(experience, time);
  word(experience);
}

function depictHands({
  room,
  world,
  seesRoom,
  inputs,
  displacement,
  showsGhosts,
}: Experience): void {
  for (const input of inputs) {
    const { side } = input;
    const hand = room.hands[side];
    hand.touch(displacement.claimed(side));
    hand.visible = input.tracked && (world > 0.01 || !seesRoom);
    if (hand.visible) hand.place(displacement.displayed[side], input.radii, 16, 12);
    const ghost = room.ghosts[side];
    ghost.visible = showsGhosts && input.tracked;
    if (ghost.visible) ghost.place(input.poses, input.radii, 16, 12);
    room.panel.poke(`${side}`, input.joint(9, tip));
  }
}

/** Where to touch next: on the prop, once it is known where it stands, and on a small model. */
function guide({ room, session, calibrator, head }: Experience, time: number): void {
  if (!calibrator) return;
  const calibrating = session.phase === "calibrate" && session.pauses.size === 0;
  const place = calibrating ? calibrator.place : null;
  room.ring.mark(calibrator.calibration ? place : null, time);
  const shown = calibrator.way === "places" ? place : null;
  beside.set(0.27, 0, 0.03).applyQuaternion(room.panel.quaternion).add(room.panel.position);
  room.miniature.show(calibrator.prop, shown, beside, head, time);
}

/** How far the prop is from where the warp holds; "lost" while its controller is not tracked. */
function howFar({ carrier, calibrator }: Experience): Facts["carried"] {
  return carrier?.tracked ? carrier.away(calibrator.prop.surface.centre) : "lost";
}

function word(experience: Experience): void {
  const { session, calibrator, displacement, notice, warning, seesRoom, resolver, room } =
    experience;
  if (!calibrator) return;
  const { audit } = displacement.watch;
  const said = instruct(session, calibrator, {
    audit: audit.line,
    drifted: audit.hasDrifted,
    notice,
    warning,
    seesRoom,
    solving: resolver,
    carried: displacement.holds ? null : howFar(experience),
  });
  room.panel.content = {
    ...said,
    lines: said.lines.filter((line) => line !== ""),
    buttons: buttonsOf(experience),
    recording: experience.context.recorder.status.participant,
  };
}

const matrix = new Matrix4();
const tip = new Vector3();
const beside = new Vector3();
