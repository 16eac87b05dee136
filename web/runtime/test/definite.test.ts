import { describe, expect, it } from "vitest";
import {
  factor,
  factorFour,
  halfSolve,
  halfSolveFour,
  otherHalf,
  otherHalfFour,
} from "../src/hand/definite.js";

/** M Mᵀ with a little on the diagonal, or taken away from it. */
function matrix(seed: number, more: number): Float64Array {
  const M = Float64Array.from({ length: 16 }, (_, n) => Math.sin(37 * seed + 7.3 * n * n + n));
  const A = new Float64Array(16);
  for (let i = 0; i < 4; i++) {
    for (let j = 0; j < 4; j++) {
      for (let k = 0; k < 4; k++) {
        A[4 * i + j] = A[4 * i + j]! + M[4 * i + k]! * M[4 * j + k]!;
      }
    }
    A[5 * i] = A[5 * i]! + more;
  }
  return A;
}

const springs = Float64Array.of(0.1, 0.3, 0.2, 0.4);

describe("four unknowns", () => {
  it("are solved for, and refused, as any number of them: to the bit", () => {
    let refused = 0;
    for (let seed = 1; seed < 200; seed++) {
      const A = matrix(seed, seed % 3 === 0 ? -0.3 : 0.01);
      const [one, other] = [A.slice(), A.slice()];
      const isDefinite = factor(one, 4, springs);
      expect(factorFour(other, springs)).toBe(isDefinite);
      if (!isDefinite) {
        refused++;
        continue;
      }
      expect(other).toEqual(one);
      const b = matrix(seed + 500, 0);
      const c = b.slice();
      halfSolve(one, 4, b, 8);
      halfSolveFour(other, c, 8);
      expect(c).toEqual(b);
      otherHalf(one, 4, b);
      otherHalfFour(other, c);
      expect(c).toEqual(b);
    }
    expect(refused).toBeGreaterThan(20);
    expect(refused).toBeLessThan(180);
  });
});
