/** A warp file that is truncated, foreign, newer or inconsistent; the message says what to do. */
export class WarpFileError extends Error {
  override readonly name = "WarpFileError";
}

/** A goal that bases cannot reach: not affine, not finite, or of an unknown prop. */
export class GoalError extends Error {
  override readonly name = "GoalError";
}
