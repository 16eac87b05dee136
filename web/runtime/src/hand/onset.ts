/** s: a frame later than that counts as this late, lest the hand jump after a pause. */
const LONGEST_STEP = 0.1;

/** A weight from 0 to 1 that eases in and out at a bounded rate; u itself is never rate-limited. */
export class Onset {
  /** The share of the displacement that is shown. */
  weight = 0;
  private time = Number.NaN;

  /**
   * @param duration s from 0 to 1; 0 for at once.
   * @throws RangeError the duration is negative or not finite.
   */
  constructor(readonly duration: number) {
    if (!(Number.isFinite(duration) && duration >= 0)) {
      throw new RangeError(`The onset takes ${duration} s; a finite time ≥ 0 is needed.`);
    }
  }

  /** The weight at `time` (s), moved towards 1 where `wanted`, else towards 0. */
  advance(time: number, wanted: boolean): number {
    const elapsed = Math.min(Math.max(time - this.time, 0), LONGEST_STEP);
    if (Number.isFinite(time)) {
      this.time = time;
    }
    const seconds = Number.isFinite(elapsed) ? elapsed : 0;
    const step = this.duration > 0 ? seconds / this.duration : 1;
    this.weight = wanted ? Math.min(this.weight + step, 1) : Math.max(this.weight - step, 0);
    return this.weight;
  }
}
