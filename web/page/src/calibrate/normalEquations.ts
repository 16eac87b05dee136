import { CholeskyDecomposition, Matrix } from "ml-matrix";

/** JᵀWJ δ = −JᵀW e, summed row by row. */
export class NormalEquations {
  /** The row's derivative; fill it before `add`. */
  readonly slope: Float64Array;
  private readonly left: Float64Array;
  private readonly right: Float64Array;

  constructor(readonly size: number) {
    this.slope = new Float64Array(size);
    this.left = new Float64Array(size * size);
    this.right = new Float64Array(size);
  }

  clear(): void {
    this.left.fill(0);
    this.right.fill(0);
  }

  add(weight: number, residual: number): void {
    const { size, slope, left, right } = this;
    for (let i = 0; i < size; i++) {
      const share = weight * slope[i]!;
      right[i]! -= share * residual;
      for (let j = 0; j <= i; j++) left[i * size + j]! += share * slope[j]!;
    }
  }

  /** Information that unknown `i`, now at `value`, should be 0. */
  damp(i: number, information: number, value: number): void {
    this.left[i * this.size + i]! += information;
    this.right[i]! -= information * value;
  }

  /** JᵀWJ. */
  matrix(): Matrix {
    const full = Matrix.zeros(this.size, this.size);
    for (let i = 0; i < this.size; i++) {
      for (let j = 0; j <= i; j++) {
        full.set(i, j, this.left[i * this.size + j]!);
        full.set(j, i, this.left[i * this.size + j]!);
      }
    }
    return full;
  }

  /** δ. */
  solve(): number[] {
    const right = Matrix.columnVector([...this.right]);
    return new CholeskyDecomposition(this.matrix()).solve(right).to1DArray();
  }
}
