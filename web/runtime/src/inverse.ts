/**
 * Where the real hand must be for a displayed position, for a warp of any kind.
 *
 * A root of f(x) = y satisfies |x − y| = |u(x)|, so all roots lie in a ball around y. Starts are
 * spread over that ball; a start is kept where its first Newton step is no longer than the starts are
 * apart, and damped Newton goes on from there. One more start follows x + s u(x) = y from s = 0 to 1.
 * Of the roots found the nearest is taken: a fold smaller than the starts' spacing may be missed.
 */

import type { Warp } from "./warp.js";

/** m: how close to the displayed position f must come for a root to be accepted. */
const RESIDUAL = 1e-9;
const STARTS = 200;
const STEPS = 30;
const CONTINUATION = 8;

/**
 * Write the root nearest to y over y; false, and y untouched, where none was found.
 * @param reach m, a bound on |u|.
 */
export function searchInverse(warp: Warp, y: Float64Array, reach: number): boolean {
  const d = warp.dimension;
  const newton = new Newton(warp, y);
  const ball = BALLS[d];
  const apart = 2 * reach * (1 / STARTS) ** (1 / d);
  const x = new Float64Array(d);
  const nearest = new Float64Array(d);
  let best = Number.POSITIVE_INFINITY;
  for (let n = -1; n < STARTS; n++) {
    if (n < 0) {
      newton.follow(x);
    } else {
      for (let e = 0; e < d; e++) {
        x[e] = y[e]! + reach * ball[d * n + e]!;
      }
      if (!(newton.step(x, 1) <= 2 * apart)) {
        continue;
      }
      newton.take(x, 1);
    }
    if (newton.settle(x, reach)) {
      const distance = x.reduce((sum, value, e) => sum + (value - y[e]!) ** 2, 0);
      if (distance < best) {
        best = distance;
        nearest.set(x);
      }
    }
  }
  if (best < Number.POSITIVE_INFINITY) {
    y.set(nearest);
  }
  return best < Number.POSITIVE_INFINITY;
}

/** Newton's method for x + s u(x) = y. */
class Newton {
  private readonly d: number;
  private readonly y: Float64Array;
  private readonly u: Float64Array;
  private readonly slope: Float64Array;
  private readonly delta: Float64Array;
  private readonly trial: Float64Array;

  constructor(
    private readonly warp: Warp,
    y: Float64Array,
  ) {
    this.d = warp.dimension;
    this.y = Float64Array.from(y);
    this.u = new Float64Array(this.d);
    this.slope = new Float64Array(this.d * this.d);
    this.delta = new Float64Array(this.d);
    this.trial = new Float64Array(this.d);
  }

  /** The step at x, kept for `take`; its length. Regularised where the slope is all but singular. */
  step(x: Float64Array, share: number): number {
    const { d, u, slope, delta } = this;
    this.warp.displacement(x, u);
    this.warp.jacobian(x, slope);
    for (let i = 0; i < d; i++) {
      for (let j = 0; j < d; j++) {
        const eye = i === j ? 1 : 0;
        slope[d * j + i] = eye + share * (slope[d * j + i]! - eye);
      }
    }
    const normal = new Float64Array(d * d);
    const right = new Float64Array(d);
    for (let i = 0; i < d; i++) {
      for (let e = 0; e < d; e++) {
        right[i] = right[i]! + slope[d * i + e]! * (x[e]! + share * u[e]! - this.y[e]!);
        for (let j = 0; j < d; j++) {
          normal[d * i + j] = normal[d * i + j]! + slope[d * i + e]! * slope[d * j + e]!;
        }
      }
      normal[d * i + i] = normal[d * i + i]! + 1e-10;
    }
    solveSymmetric(normal, right, d);
    let length = 0;
    for (let e = 0; e < d; e++) {
      delta[e] = -right[e]!;
      length += delta[e]! ** 2;
    }
    return Math.sqrt(length);
  }

  take(x: Float64Array, part: number): void {
    for (let e = 0; e < this.d; e++) {
      x[e] = x[e]! + part * this.delta[e]!;
    }
  }

  /** x at the end of the path of x + s u(x) = y from s = 0 to 1. */
  follow(x: Float64Array): void {
    x.set(this.y);
    for (let n = 1; n <= CONTINUATION; n++) {
      for (let twice = 0; twice < 2; twice++) {
        this.step(x, n / CONTINUATION);
        this.take(x, 1);
      }
    }
  }

  /** Go on from x, damped; whether it came to a root. */
  settle(x: Float64Array, reach: number): boolean {
    let residual = this.residual(x);
    for (let n = 0; n < STEPS && residual > 1e-3 * RESIDUAL; n++) {
      const length = this.step(x, 1);
      let part = Math.min(1, (0.5 * reach) / Math.max(length, 1e-300));
      let better = false;
      for (let tries = 0; tries < 6 && !better; tries++, part *= 0.4) {
        this.trial.set(x);
        this.take(this.trial, part);
        const size = this.residual(this.trial);
        better = size < residual;
        if (better) {
          x.set(this.trial);
          residual = size;
        }
      }
      if (!better) {
        break;
      }
    }
    return residual <= RESIDUAL;
  }

  private residual(x: Float64Array): number {
    this.warp.displacement(x, this.u);
    let sum = 0;
    for (let e = 0; e < this.d; e++) {
      sum += (x[e]! + this.u[e]! - this.y[e]!) ** 2;
    }
    return Math.sqrt(sum);
  }
}

/** Solve A x = b by Cholesky's factors, A positive definite, x over b. */
export function solveSymmetric(A: Float64Array, b: Float64Array, n: number): void {
  for (let j = 0; j < n; j++) {
    for (let i = j; i < n; i++) {
      let sum = A[n * i + j]!;
      for (let k = 0; k < j; k++) {
        sum -= A[n * i + k]! * A[n * j + k]!;
      }
      A[n * i + j] = i === j ? Math.sqrt(sum) : sum / A[n * j + j]!;
    }
  }
  for (let i = 0; i < n; i++) {
    for (let k = 0; k < i; k++) {
      b[i] = b[i]! - A[n * i + k]! * b[k]!;
    }
    b[i] = b[i]! / A[n * i + i]!;
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let k = i + 1; k < n; k++) {
      b[i] = b[i]! - A[n * k + i]! * b[k]!;
    }
    b[i] = b[i]! / A[n * i + i]!;
  }
}

/** Points spread evenly over the unit ball, the same every time. */
function ballOf(count: number, d: 2 | 3): Float64Array {
  const golden = (1 + Math.sqrt(5)) / 2;
  const out = new Float64Array(count * d);
  for (let n = 0; n < count; n++) {
    const size = ((n + 0.5) / count) ** (1 / d);
    const turn = (2 * Math.PI * n) / golden;
    // heights by a second irrational step, lest they grow with the radius
    const height = d === 2 ? 0 : 2 * ((n * Math.SQRT2 + 0.5) % 1) - 1;
    const flat = Math.sqrt(1 - height * height);
    out[d * n] = flat * Math.cos(turn) * size;
    out[d * n + 1] = flat * Math.sin(turn) * size;
    if (d === 3) {
      out[3 * n + 2] = height * size;
    }
  }
  return out;
}

const BALLS = { 2: ballOf(STARTS, 2), 3: ballOf(STARTS, 3) };
