/** Small symmetric systems, row by row, of which the lower half is read. */

/** A pivot is to keep this share of what the unknown's own spring alone would give. */
const LEAST = 0.05;

/**
 * A = L Lᵀ, into the lower half of A, with 1 / L_jj on its diagonal.
 * @param springs (n), stiffness that each unknown has by itself.
 * @returns whether A is definite enough.
 */
export function factor(A: Float64Array, n: number, springs: Float64Array): boolean {
  for (let j = 0; j < n; j++) {
    let pivot = A[n * j + j]!;
    for (let k = 0; k < j; k++) {
      pivot -= A[n * j + k]! * A[n * j + k]!;
    }
    if (!(pivot > LEAST * springs[j]!)) {
      return false;
    }
    const scale = 1 / Math.sqrt(pivot);
    A[n * j + j] = scale;
    for (let i = j + 1; i < n; i++) {
      let sum = A[n * i + j]!;
      for (let k = 0; k < j; k++) {
        sum -= A[n * i + k]! * A[n * j + k]!;
      }
      A[n * i + j] = sum * scale;
    }
  }
  return true;
}

/** b = L⁻¹ b, from `at` on. */
export function halfSolve(L: Float64Array, n: number, b: Float64Array, at = 0): void {
  for (let i = 0; i < n; i++) {
    let sum = b[at + i]!;
    for (let k = 0; k < i; k++) {
      sum -= L[n * i + k]! * b[at + k]!;
    }
    b[at + i] = sum * L[n * i + i]!;
  }
}

/** `factor` of four unknowns, written out: that of fingers is done some fifty times a hand and frame. */
export function factorFour(A: Float64Array, springs: Float64Array): boolean {
  const pivot0 = A[0]!;
  if (!(pivot0 > LEAST * springs[0]!)) {
    return false;
  }
  const l00 = 1 / Math.sqrt(pivot0);
  const l10 = A[4]! * l00;
  const l20 = A[8]! * l00;
  const l30 = A[12]! * l00;
  const pivot1 = A[5]! - l10 * l10;
  if (!(pivot1 > LEAST * springs[1]!)) {
    return false;
  }
  const l11 = 1 / Math.sqrt(pivot1);
  const l21 = (A[9]! - l20 * l10) * l11;
  const l31 = (A[13]! - l30 * l10) * l11;
  const pivot2 = A[10]! - l20 * l20 - l21 * l21;
  if (!(pivot2 > LEAST * springs[2]!)) {
    return false;
  }
  const l22 = 1 / Math.sqrt(pivot2);
  const l32 = (A[14]! - l30 * l20 - l31 * l21) * l22;
  const pivot3 = A[15]! - l30 * l30 - l31 * l31 - l32 * l32;
  if (!(pivot3 > LEAST * springs[3]!)) {
    return false;
  }
  A[0] = l00;
  A[4] = l10;
  A[5] = l11;
  A[8] = l20;
  A[9] = l21;
  A[10] = l22;
  A[12] = l30;
  A[13] = l31;
  A[14] = l32;
  A[15] = 1 / Math.sqrt(pivot3);
  return true;
}

/** `halfSolve` of four unknowns. */
export function halfSolveFour(L: Float64Array, b: Float64Array, at: number): void {
  const x0 = b[at]! * L[0]!;
  const x1 = (b[at + 1]! - L[4]! * x0) * L[5]!;
  const x2 = (b[at + 2]! - L[8]! * x0 - L[9]! * x1) * L[10]!;
  b[at + 3] = (b[at + 3]! - L[12]! * x0 - L[13]! * x1 - L[14]! * x2) * L[15]!;
  b[at] = x0;
  b[at + 1] = x1;
  b[at + 2] = x2;
}

/** b = L⁻ᵀ b. */
export function otherHalf(L: Float64Array, n: number, b: Float64Array): void {
  for (let i = n - 1; i >= 0; i--) {
    let sum = b[i]!;
    for (let k = i + 1; k < n; k++) {
      sum -= L[n * k + i]! * b[k]!;
    }
    b[i] = sum * L[n * i + i]!;
  }
}

/** `otherHalf` of four unknowns. */
export function otherHalfFour(L: Float64Array, b: Float64Array): void {
  const x3 = b[3]! * L[15]!;
  const x2 = (b[2]! - L[14]! * x3) * L[10]!;
  const x1 = (b[1]! - L[9]! * x2 - L[13]! * x3) * L[5]!;
  b[0] = (b[0]! - L[4]! * x1 - L[8]! * x2 - L[12]! * x3) * L[0]!;
  b[1] = x1;
  b[2] = x2;
  b[3] = x3;
}
