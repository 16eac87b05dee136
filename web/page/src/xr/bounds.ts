import { Matrix4, Vector3 } from "three";
import { isBeyondBounds } from "./safety.js";

/** Seconds between two looks: bounds are redrawn, and props put elsewhere, by hand. */
const INTERVAL = 1;

/** The outline on the floor that the person has told the device of, in the frame it is given in. */
export class PlayBounds {
  #space: XRBoundedReferenceSpace | null = null;
  #looked = Number.NEGATIVE_INFINITY;
  #outside: readonly string[] = [];

  /** Ask the device for them; it may know of none, or keep them to itself. */
  constructor(xr: XRSession) {
    xr.requestReferenceSpace("bounded-floor").then(
      (space) => {
        this.#space = space as XRBoundedReferenceSpace;
      },
      () => {},
    );
  }

  /** Whether it is time for another look. */
  due(time: number): boolean {
    return this.#space !== null && time - this.#looked >= INTERVAL;
  }

  /**
   * Names of the things that have come to stand outside since the last look.
   * @param places by name, m, `room` frame.
   */
  look(
    time: number,
    frame: XRFrame,
    room: XRReferenceSpace,
    places: ReadonlyMap<string, Vector3>,
  ): string[] {
    const pose = this.#space && frame.getPose(this.#space, room);
    if (!this.#space || !pose) return [];
    this.#looked = time;
    const T_bounds_room = matrix.fromArray(pose.transform.matrix).invert();
    const outline = this.#space.boundsGeometry ?? []; // some devices leave it out
    const before = this.#outside;
    this.#outside = [...places]
      .filter(([, at]) => isBeyondBounds(point.copy(at).applyMatrix4(T_bounds_room), outline))
      .map(([name]) => name);
    return this.#outside.filter((name) => !before.includes(name));
  }

  /** What stands outside is to be told of anew. */
  forget(): void {
    this.#outside = [];
    this.#looked = Number.NEGATIVE_INFINITY;
  }
}

const matrix = new Matrix4();
const point = new Vector3();
