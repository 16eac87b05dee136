/**
 * touchwarp's runtime: reads warp files and displaces hands.
 *
 * Lengths are metres, angles radians, times seconds. A matrix is 16 numbers in column-major order,
 * as in WebXR (`XRRigidTransform.matrix`) and three.js (`Matrix4.elements`); `T_to_from` takes points
 * of the frame `from` to the frame `to`. Points are rows of x, y, z in one array (x, y in a plane
 * scene). Calls that run at display rate write into the caller's arrays and allocate nothing.
 */

export { AffineBases, type AffineWarp } from "./bases.js";
export { GoalError, WarpFileError } from "./errors.js";
export { type ArrivingWarp, type FetchOptions, openWarp } from "./fetch.js";
export { parseWarp } from "./file.js";
export { type CarriedOptions, CarriedWarp } from "./hand/carried.js";
export type { NearestSurface } from "./hand/contact.js";
export type { HandOptions } from "./hand/options.js";
export { calibratePad, type Pad } from "./hand/pad.js";
export { HandRetargeter } from "./hand/retargeter.js";
export { FINGERS, type Finger, JOINTS } from "./hand/skeleton.js";
export type { PlaneWarp } from "./plane.js";
export type { TableWarp } from "./table.js";
export type { BasisProp, Matrix, Outline, Points, Warp, WarpMeta } from "./warp.js";
