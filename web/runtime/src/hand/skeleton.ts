/**
 * The tracked hand of WebXR and OpenXR: its joints, and the skeleton that links them.
 *
 * A joint's frame has −z along its bone towards the tip and +y out of the back of the hand, so that
 * bending the finger turns −z towards −y: a turn by a negative angle about x. The palm (wrist,
 * metacarpals, knuckles) is one rigid body; each finger has four angles: at its base one of flexion
 * and one of abduction, and flexion at its two other joints.
 */

export const FINGERS = ["thumb", "index", "middle", "ring", "little"] as const;
export type Finger = (typeof FINGERS)[number];

const BONES = [
  "metacarpal",
  "phalanx-proximal",
  "phalanx-intermediate",
  "phalanx-distal",
  "tip",
] as const;

/** WebXR's names and order, 25; OpenXR has a palm before them, 26. */
export const JOINTS: readonly string[] = [
  "wrist",
  "thumb-metacarpal",
  "thumb-phalanx-proximal",
  "thumb-phalanx-distal",
  "thumb-tip",
  ...["index", "middle", "ring", "pinky"].flatMap((finger) =>
    BONES.map((bone) => `${finger}-finger-${bone}`),
  ),
];

export const JOINT_COUNT = 25;

/** The joint at each finger's base: the thumb's metacarpal, the other fingers' knuckles. */
export const BASES = [1, 6, 11, 16, 21] as const;
export const TIPS = [4, 9, 14, 19, 24] as const;

/**
 * Whose frame a base's angles are counted in. The thumb's own: it is held near its tracked pose,
 * since its base is a saddle whose angles to the wrist tell little.
 */
export const PARENTS = [1, 5, 10, 15, 20] as const;

const DEGREE = Math.PI / 180;
const THUMB = [-25, 25, -25, 25, -60, 10, -85, 20];
const FINGER = [-90, 30, -25, 25, -110, 5, -80, 10];

/**
 * rad, (5, 4, 2): least and greatest flexion and abduction at the base, then flexion of the two
 * other joints; of the thumb's base, relative to its tracked pose. A tracked angle beyond a limit
 * moves the limit there.
 */
export const LIMITS: Float64Array = Float64Array.from(
  [THUMB, FINGER, FINGER, FINGER, FINGER].flat(),
  (degrees) => degrees * DEGREE,
);

/** m: distance of a tracked fingertip from the skin where the device gives none. */
export const TIP_RADIUS = 8e-3;
