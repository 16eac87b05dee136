/** The table's data: displacement on a sparse octree of bricks; see docs/warp-file.md. */

/** Cells of a brick along each axis. */
export const CELLS = 8;
/** Numbers of one channel in a brick: 9³ nodes. */
export const BRICK = 729;
export const SHEET = 81;
export const LINE = 9;

/** What a file says of its bricks, before their values have come. */
export interface BrickIndex {
  /** Column-major, table frame to scene frame. */
  readonly T_scene_table: Float64Array;
  /** m, the sides of one cell of a root brick. */
  readonly spacing: Float64Array;
  readonly rootShape: readonly number[];
  readonly root: Int32Array;
  readonly child: Int32Array;
  readonly slot: Int32Array;
  /** Rows of values. */
  readonly rows: number;
  readonly channels: number;
  readonly mirrorDepth: number | null;
  readonly levelBricks: readonly number[];
  readonly levelSlots: readonly number[];
}

/** A table of bricks whose levels come one after another; what is there can be looked up. */
export class Bricks {
  readonly T_scene_table: Float64Array;
  readonly rootShape: readonly number[];
  /** Sides of a root brick, m. */
  readonly width: Float64Array;
  /** 0 where there is no sliding plane. */
  readonly mirrorDepth: number;
  readonly root: Int32Array;
  /** Children whose level has arrived, else −1. */
  readonly child: Int32Array;
  readonly slot: Int32Array;
  readonly channels: number;
  readonly levelCount: number;
  /** Level and place (x, y, z on the dense grid of that level) of each brick. */
  readonly level: Int32Array;
  readonly position: Int32Array;
  readonly values: Float32Array;
  private readonly index: BrickIndex;
  private loaded = 0;

  /** @throws Error where the index contradicts itself. */
  constructor(index: BrickIndex, values: Float32Array) {
    const { level, position } = placeBricks(index);
    this.index = index;
    this.level = level;
    this.position = position;
    this.T_scene_table = index.T_scene_table;
    this.rootShape = index.rootShape;
    this.width = index.spacing.map((side) => side * CELLS);
    this.mirrorDepth = index.mirrorDepth ?? 0;
    this.root = index.root;
    this.slot = index.slot;
    this.channels = index.channels;
    this.levelCount = index.levelBricks.length - 1;
    this.child = new Int32Array(index.child.length).fill(-1);
    this.values = values;
  }

  get levelsLoaded(): number {
    return this.loaded;
  }

  /** Rows of values up to the end of a level. */
  rowsOf(level: number): number {
    return this.index.levelSlots[level + 1]!;
  }

  /**
   * Use the next level from now on; its rows stand in `values`.
   * @throws Error where one of its values is not finite.
   */
  addLevel(): void {
    const { levelBricks, levelSlots, child } = this.index;
    const stride = BRICK * this.channels;
    const level = this.loaded;
    for (let n = levelSlots[level]! * stride; n < levelSlots[level + 1]! * stride; n++) {
      if (!Number.isFinite(this.values[n]!)) {
        const row = Math.floor(n / stride);
        throw new Error(`The values of row ${row} hold NaN or infinity; finite is needed.`);
      }
    }
    if (level > 0) {
      const from = 8 * levelBricks[level - 1]!;
      const to = 8 * levelBricks[level]!;
      this.child.set(child.subarray(from, to), from);
    }
    this.loaded = level + 1;
  }
}

/** Level and place of every brick, once everything that the format promises has been checked. */
function placeBricks(index: BrickIndex): { level: Int32Array; position: Int32Array } {
  const { root, child, slot, rootShape, spacing, mirrorDepth } = index;
  if (spacing.length !== 3 || !spacing.every((side) => side > 0 && Number.isFinite(side))) {
    throw new Error(`The cell spacing is ${[...spacing]}; three lengths > 0 are needed.`);
  }
  if (rootShape.length !== 3 || root.length === 0) {
    throw new Error(`The root index has shape ${rootShape}; (nx, ny, nz), none 0, is needed.`);
  }
  if (child.length !== 8 * slot.length) {
    throw new Error(
      `The child index has ${child.length} numbers for ${slot.length} bricks; 8 a brick are needed.`,
    );
  }
  if (mirrorDepth !== null && !(mirrorDepth > 0 && Number.isFinite(mirrorDepth))) {
    throw new Error(`The mirror depth is ${mirrorDepth}; a length > 0, or none, is needed.`);
  }
  const count = slot.length;
  const level = new Int32Array(count).fill(-1);
  const position = new Int32Array(3 * count);
  const starts = [0];
  const rows = [0];
  let placed = 0;
  let row = 0;
  const place = (brick: number, depth: number, x: number, y: number, z: number): void => {
    if (brick < -1 || brick >= count) {
      throw new Error(
        `The index names brick ${brick}, but the table has bricks 0 to ${count - 1}.`,
      );
    }
    if (brick < 0) {
      return;
    }
    if (level[brick] !== -1) {
      throw new Error("The brick index names a brick twice; every brick has one parent.");
    }
    level[brick] = depth;
    position[3 * brick] = x;
    position[3 * brick + 1] = y;
    position[3 * brick + 2] = z;
    placed++;
  };
  const [, ny, nz] = rootShape as [number, number, number];
  for (let n = 0; n < root.length; n++) {
    place(root[n]!, 0, Math.floor(n / (ny * nz)), Math.floor(n / nz) % ny, n % nz);
  }
  // Bricks stand in order of level: those of one level name all those of the next.
  for (let depth = 0, first = 0; first < placed; depth++) {
    const last = placed;
    for (let brick = first; brick < last; brick++) {
      if (level[brick] !== depth) {
        throw new Error("Its bricks are not in order of level, as level_bricks tells it.");
      }
      let children = 0;
      for (let octant = 0; octant < 8; octant++) {
        const deeper = child[8 * brick + octant]!;
        children += deeper < 0 ? 0 : 1;
        place(
          deeper,
          depth + 1,
          2 * position[3 * brick]! + (octant >> 2),
          2 * position[3 * brick + 1]! + ((octant >> 1) & 1),
          2 * position[3 * brick + 2]! + (octant & 1),
        );
      }
      if (slot[brick] === row) {
        row++;
      } else if (slot[brick] !== -1) {
        throw new Error(
          `The slots do not name each of the ${index.rows} rows of values once and in order; they must, with -1 for bricks that have no values.`,
        );
      } else if (children < 8) {
        throw new Error(
          `Brick ${brick} has neither values nor all eight children; one of them is needed.`,
        );
      }
    }
    starts.push(last);
    rows.push(row);
    first = last;
  }
  if (starts.length === 1) {
    starts.push(0); // a table of no bricks: u = 0 everywhere
    rows.push(0);
  }
  if (placed < count) {
    throw new Error(
      `The brick index never names ${count - placed} of ${count} bricks; every brick has one parent.`,
    );
  }
  if (row !== index.rows) {
    throw new Error(`The slots name ${row} rows of values, but there are ${index.rows}.`);
  }
  if (String(starts) !== String(index.levelBricks) || String(rows) !== String(index.levelSlots)) {
    throw new Error("Its bricks are not in order of level, as level_bricks tells it.");
  }
  return { level, position };
}
