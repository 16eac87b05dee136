/** A right hand that points with its index finger, in m: the desk's probe. */

// Wrist frame as in WebXR: −z to the fingers, y to the back of the hand, x to the little finger.
const POSITIONS: readonly (readonly [number, number, number])[] = [
  [0, 0, 0],
  [-0.021, -0.009, -0.027],
  [-0.037, -0.02, -0.056],
  [-0.03, -0.032, -0.085],
  [-0.016, -0.038, -0.104],
  [-0.015, 0, -0.036],
  [-0.023, 0.002, -0.091],
  [-0.0245, -0.001, -0.131],
  [-0.025, -0.007, -0.155],
  [-0.0255, -0.014, -0.174],
  [-0.003, 0, -0.034],
  [-0.003, 0.003, -0.095],
  [-0.004, -0.03, -0.122],
  [-0.005, -0.05, -0.103],
  [-0.006, -0.053, -0.081],
  [0.009, -0.001, -0.033],
  [0.014, 0.001, -0.089],
  [0.012, -0.031, -0.112],
  [0.01, -0.048, -0.092],
  [0.008, -0.049, -0.072],
  [0.019, -0.004, -0.031],
  [0.03, -0.005, -0.078],
  [0.028, -0.03, -0.094],
  [0.025, -0.042, -0.077],
  [0.023, -0.042, -0.06],
];

const RADII = [
  [0.022],
  [0.016, 0.013, 0.011, 0.009],
  [0.017, 0.0115, 0.0095, 0.0085, 0.0075],
  [0.017, 0.012, 0.0098, 0.0086, 0.0076],
  [0.016, 0.0112, 0.0092, 0.0082, 0.0072],
  [0.015, 0.01, 0.0082, 0.0075, 0.0066],
].flat();

export const INDEX_TIP = 9;

export const pointingRadii = Float32Array.from(RADII);

/** 25 × 16 numbers, wrist frame; each joint's −z looks along its bone, as in WebXR. */
export function pointingPoses(): Float32Array {
  const out = new Float32Array(25 * 16);
  for (let joint = 0; joint < 25; joint++) {
    const here = POSITIONS[joint]!;
    const isTip = joint !== 0 && (joint === 4 || (joint > 4 && (joint - 4) % 5 === 0));
    const [a, b] = isTip
      ? [POSITIONS[joint - 1]!, here]
      : [here, POSITIONS[joint === 0 ? 10 : joint + 1]!];
    const z = unit([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
    const x = unit([z[2], 0, -z[0]]); // y × z with y upright
    const y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
    out.set([...x, 0, ...y, 0, ...z, 0, ...here, 1], 16 * joint);
  }
  return out;
}

function unit(v: [number, number, number]): [number, number, number] {
  const length = Math.hypot(...v);
  return [v[0] / length, v[1] / length, v[2] / length];
}
