import { type AffineBases, type AffineWarp, openWarp, type Warp } from "touchwarp";
import type { Matrix, PropState, SceneState, WarpFile } from "./messages.js";

/** Goals that differ by less than the server rounds them to are the same. */
const SAME_GOAL = 1e-4;

/** A table that is here or on its way, with the scene that it was made for. */
interface Held<Table> {
  readonly file: WarpFile;
  /** The goals and props for which it holds. */
  readonly scene: string;
  /** Null until its first level has come. */
  table: Table | null;
}

/**
 * The warp in use: the exact one where it belongs to the goals shown, else the instant one that the
 * bases give. Files are fetched when the state names new ones, and used from their first level on,
 * once they are the better ones.
 */
export class Tables {
  /** The warp that hands go through now; null until one that holds for the scene shown has come. */
  current: Warp | null = null;
  /** Whether `current` is the solved warp of the scene shown. */
  exact = false;
  /** Counts every change of `current` and of its levels. */
  version = 0;
  /** Counts every change of what is to be displayed; within one, warps differ by their errors only. */
  generation = 0;
  /** Why the file that the last state names could not be fetched. */
  problem: string | null = null;

  #warp: Held<Warp> | null = null;
  /** The solved warp that is on its way, while `#warp` is still the one before. */
  #next: Held<Warp> | null = null;
  #bases: Held<AffineBases> | null = null;
  #instant: AffineWarp | null = null;
  #goals = new Map<string, Float64Array>();
  /** Props whose goal was moved here, and which no state has told so yet. */
  #moved = new Set<string>();
  #scene = "";
  #stand = "";
  #warpCurrent = false;
  #listeners = new Set<() => void>();

  /** @param open how a file is opened: as it arrives. */
  constructor(readonly open: typeof openWarp = openWarp) {}

  listen(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  /** The file of `current`. */
  get file(): WarpFile | null {
    if (this.current === null) return null;
    return this.current === this.#instant ? this.#bases!.file : this.#warp!.file;
  }

  /** The estimated error of `current` in mm, what float16 adds included; null where unknown. */
  get errorMm(): number | null {
    return this.current === this.#instant ? this.#instantError() : this.#solvedError();
  }

  /** What float16, and levels that are still on their way, add to the error, mm. */
  get addedErrorMm(): number {
    return addedError(this.current, this.file);
  }

  /** Whether virtual objects can be moved with no solve. */
  get instant(): boolean {
    return this.#instant !== null;
  }

  /** Whether anything is displayed where no state has told it. */
  get moved(): boolean {
    return this.#moved.size > 0;
  }

  /** Take over what a new state names; what was moved here stays until a state tells it so. */
  update(state: SceneState): void {
    this.problem = null; // what failed is asked for again, or no longer wanted
    this.#warpCurrent = state.warp_current;
    const stand = JSON.stringify(state.props.map(({ pose, surface }) => [pose, surface]));
    this.#scene = JSON.stringify([stand, state.props.map(({ goal }) => goal)]);
    if (stand !== this.#stand) this.#moved.clear();
    for (const prop of state.props) if (this.shows(prop)) this.#moved.delete(prop.name);
    if (stand !== this.#stand || !this.#isShown(state)) this.#takeGoals(state);
    this.#stand = stand;
    if (state.warp !== null && state.warp_current) this.#hold(state.warp);
    if (state.bases === null) {
      this.#bases = this.#instant = null;
    } else if (state.bases.identity !== this.#bases?.file.identity) {
      void this.#fetchBases(state.bases);
    }
    this.#choose();
  }

  /** Show what a state tells, whatever was moved here: it is newer, or that was refused. */
  restore(state: SceneState): void {
    this.#moved.clear();
    this.update(state);
  }

  /** Show a prop's virtual object elsewhere, at once. */
  setGoal(prop: string, goal: Float64Array): void {
    this.#goals.set(prop, goal);
    this.#moved.add(prop);
    this.generation++;
    this.#instant?.setGoal(prop, goal);
    this.#choose();
  }

  goal(prop: string): Float64Array | undefined {
    return this.#goals.get(prop);
  }

  /** Whether a prop's goal is the one that is displayed already, as after a drag. */
  shows({ name, goal }: PropState): boolean {
    if (goal === null) return true; // what cannot be dragged
    const shown = this.#goals.get(name);
    return (
      shown !== undefined &&
      columns(goal).every((value, k) => Math.abs(value - shown[k]!) < SAME_GOAL)
    );
  }

  /** Whether a state tells nothing new; of what was moved here it may tell what was before that. */
  #isShown(state: SceneState): boolean {
    return state.props.every((prop) => this.#moved.has(prop.name) || this.shows(prop));
  }

  #takeGoals(state: SceneState): void {
    this.generation++;
    for (const { name, goal } of state.props) {
      if (goal !== null && !this.#moved.has(name)) this.#goals.set(name, columns(goal));
    }
  }

  /** The solved warp of the scene as it now is: the one that is here, or a new one to be fetched. */
  #hold(file: WarpFile): void {
    const isIt = (held: Held<Warp> | null) =>
      held?.file.identity === file.identity && held.scene === this.#scene;
    if (isIt(this.#next)) return;
    this.#next = null;
    if (!isIt(this.#warp)) void this.#fetchWarp(file);
  }

  #choose(): void {
    if (
      this.#next?.table != null &&
      this.#next.scene === this.#scene &&
      this.#replaces(this.#next)
    ) {
      this.#warp = this.#next;
      this.#next = null;
    }
    const warp = this.#warp;
    const holds = warp?.table != null && warp.scene === this.#scene && this.#moved.size === 0;
    // Of another λ, or of bases, a warp holds in contact but is not the one that is asked for.
    const asked = holds && this.#warpCurrent && this.#next === null;
    if (!asked && this.#instant !== null) {
      for (const [name, goal] of this.#goals) this.#instant.setGoal(name, goal);
    }
    this.exact = asked;
    this.current = asked ? warp.table : (this.#instant ?? (holds ? warp.table : null));
    this.#changed();
  }

  /** Whether a warp that is still arriving is better already than what would be in use without it. */
  #replaces({ file, table }: Held<Warp>): boolean {
    if (table!.levelsLoaded === table!.levelCount || this.current === null) return true;
    const before = this.errorMm;
    const estimate = file.estimated_error_max_mm;
    return before === null || (estimate !== null && estimate + addedError(table, file) <= before);
  }

  #solvedError(): number | null {
    const estimate = this.#warp?.file.estimated_error_max_mm ?? null;
    return estimate === null ? null : estimate + this.addedErrorMm;
  }

  #instantError(): number | null {
    const bound = this.#instant?.errorBoundMm ?? null;
    return bound === null ? null : bound + this.addedErrorMm;
  }

  async #fetchWarp(file: WarpFile): Promise<void> {
    const held: Held<Warp> = { file, scene: this.#scene, table: null };
    this.#next = held;
    const problem = await this.#fetch(file, (warp) => {
      if ("displayed" in warp) held.table = warp;
    });
    if (problem !== null && (this.#next === held || this.#warp === held)) {
      // the next state that names it asks for it again
      if (this.#next === held) this.#next = null;
      else this.#warp = null;
      this.problem = problem;
    }
    this.#choose();
  }

  async #fetchBases(file: WarpFile): Promise<void> {
    const held: Held<AffineBases> = { file, scene: this.#scene, table: null };
    this.#bases = held;
    this.#instant = null;
    const problem = await this.#fetch(file, (bases) => {
      if (this.#bases !== held || "displayed" in bases) return;
      held.table = bases;
      this.#instant = bases.warp(Object.fromEntries(this.#goals));
    });
    if (problem !== null && this.#bases === held) {
      this.#bases = this.#instant = null;
      this.problem = problem;
    }
    this.#choose();
  }

  /** Null once all of it came, else what went wrong; `use` is told when it can be used. */
  async #fetch(file: WarpFile, use: (table: Warp | AffineBases) => void): Promise<string | null> {
    try {
      const arriving = await this.open(new URL(file.url, document.baseURI), {
        onLevel: () => this.#choose(),
      });
      use(arriving.warp);
      this.#choose();
      await arriving.complete;
      return null;
    } catch (error) {
      return error instanceof Error ? error.message : String(error);
    }
  }

  #changed(): void {
    this.version++;
    for (const listener of this.#listeners) listener();
  }
}

function addedError(table: Warp | null, file: WarpFile | null): number {
  const told = table?.addedErrorMm ?? Number.NaN;
  return Number.isNaN(told) ? (file?.storage_error_mm ?? 0) : told;
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
