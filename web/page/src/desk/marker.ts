import { Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";
import type { CheckLine } from "../live/messages.js";
import { ALL, showIn } from "./layers.js";
import type { Stage } from "./stage.js";

/** The place that a line of the certificate is about. */
export class Marker extends Mesh<SphereGeometry, MeshBasicMaterial> {
  /** The line that is shown. */
  line: CheckLine | null = null;

  constructor(readonly stage: Stage) {
    const look = { color: 0xe0218a, transparent: true, opacity: 0.85, depthTest: false };
    super(new SphereGeometry(1, 24, 16), new MeshBasicMaterial(look));
    this.renderOrder = 10;
    this.visible = false;
    showIn(this, ALL);
  }

  /** Show a line's place, if it has one, of objects of this size in m; the line that is shown
   * already, no more. */
  toggle(line: CheckLine, size: number): void {
    const again = this.line === line;
    this.hide();
    if (again) return;
    this.line = line;
    if (line.where === null) return;
    this.visible = true;
    this.position.copy(new Vector3(...line.where));
    this.scale.setScalar(0.018 * size);
    this.stage.flyTo(this.position.clone(), 1.6 * size);
  }

  hide(): void {
    this.line = null;
    this.visible = false;
    this.stage.draw();
  }
}
