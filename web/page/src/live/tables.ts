import { type AffineBases, type AffineWarp, openWarp, type Warp } from "touchwarp";
import type { Matrix, SceneState, WarpFile } from "./messages.js";

/**
 * The warp in use: the exact one where it belongs to the goals shown, else the instant one that the
 * bases give. Files are fetched when the state names new ones, and used from their first level on.
 */
export class Tables {
  /** The warp that hands go through now; null until a first level has come. */
  current: Warp | null = null;
  /** Whether `current` is the solved warp of the goals shown. */
  exact = false;
  /** Counts every change of `current` and of its levels. */
  version = 0;
  problem: string | null = null;

  #warp: Warp | null = null;
  #warpFile: WarpFile | null = null;
  #bases: AffineBases | null = null;
  #basesFile: WarpFile | null = null;
  #instant: AffineWarp | null = null;
  #goals = new Map<string, Float64Array>();
  #stateGoals = "";
  #moved = false;
  #warpCurrent = false;
  #listeners = new Set<() => void>();

  listen(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  /** The file of `current`. */
  get file(): WarpFile | null {
    return this.exact ? this.#warpFile : this.#basesFile;
  }

  /** The estimated error of `current` in mm, what float16 adds included; null where unknown. */
  get errorMm(): number | null {
    const file = this.file;
    if (file === null) return null;
    const bound = this.exact ? file.estimated_error_max_mm : (this.#instant?.errorBoundMm ?? null);
    return bound === null ? null : bound + this.addedErrorMm;
  }

  /** What float16, and levels that are still on their way, add to the error, mm. */
  get addedErrorMm(): number {
    const told = this.current?.addedErrorMm ?? Number.NaN;
    return Number.isNaN(told) ? (this.file?.storage_error_mm ?? 0) : told;
  }

  /** Whether virtual objects can be moved with no solve. */
  get instant(): boolean {
    return this.#instant !== null;
  }

  /** Take over what a new state names. */
  update(state: SceneState): void {
    this.#warpCurrent = state.warp_current;
    const goals = JSON.stringify(state.props.map((prop) => prop.goal));
    if (goals !== this.#stateGoals) {
      this.#stateGoals = goals;
      for (const prop of state.props) {
        if (prop.goal !== null) this.#goals.set(prop.name, columns(prop.goal));
      }
    }
    if (state.warp_current) this.#moved = false;
    if (state.warp !== null && state.warp.identity !== this.#warpFile?.identity) {
      void this.#fetchWarp(state.warp);
    }
    if (state.bases === null) {
      this.#bases = this.#instant = this.#basesFile = null;
    } else if (state.bases.identity !== this.#basesFile?.identity) {
      void this.#fetchBases(state.bases);
    }
    this.#choose();
  }

  /** Show a prop's virtual object elsewhere, at once. */
  setGoal(prop: string, goal: Float64Array): void {
    this.#goals.set(prop, goal);
    this.#moved = true;
    this.#instant?.setGoal(prop, goal);
    this.#choose();
  }

  goal(prop: string): Float64Array | undefined {
    return this.#goals.get(prop);
  }

  #choose(): void {
    const exact = this.#warp !== null && this.#warpCurrent && !this.#moved;
    const usable = exact || this.#instant === null;
    if (!exact && this.#instant !== null) {
      for (const [name, goal] of this.#goals) this.#instant.setGoal(name, goal);
    }
    this.current = usable ? (exact ? this.#warp : this.#stale()) : this.#instant;
    this.exact = usable && this.#warp !== null;
    this.#changed();
  }

  /** An outdated warp is better than none only until something was moved. */
  #stale(): Warp | null {
    return this.#warpCurrent && !this.#moved ? this.#warp : null;
  }

  async #fetchWarp(file: WarpFile): Promise<void> {
    this.#warpFile = file;
    await this.#fetch(file, (warp) => {
      if (this.#warpFile === file && "displayed" in warp) this.#warp = warp as Warp;
    });
  }

  async #fetchBases(file: WarpFile): Promise<void> {
    this.#basesFile = file;
    await this.#fetch(file, (bases) => {
      if (this.#basesFile !== file || "displayed" in bases) return;
      this.#bases = bases;
      this.#instant = this.#bases.warp(Object.fromEntries(this.#goals));
    });
  }

  async #fetch(file: WarpFile, use: (table: Warp | AffineBases) => void): Promise<void> {
    try {
      const arriving = await openWarp(new URL(file.url, document.baseURI), {
        onLevel: () => this.#changed(),
      });
      use(arriving.warp);
      this.#choose();
      await arriving.complete;
      this.problem = null;
    } catch (error) {
      this.problem = error instanceof Error ? error.message : String(error);
    }
    this.#choose();
  }

  #changed(): void {
    this.version++;
    for (const listener of this.#listeners) listener();
  }
}

/** Rows of a matrix as the column-major array that the runtime and three.js want. */
export function columns(matrix: Matrix): Float64Array {
  const out = new Float64Array(16);
  matrix.forEach((row, i) => {
    row.forEach((value, j) => {
      out[4 * j + i] = value;
    });
  });
  return out;
}
