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
