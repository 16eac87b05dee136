// Puts an emulated headset, with hands and a clock that tests set, into the unmodified page.
(() => {
  const device = new IWER.XRDevice(IWER.metaQuest3);
  device.installRuntime({ forceInstall: true });
  device.primaryInputMode = "hand";
  device.stereoEnabled = true;
  device.position.set(0, 1.25, 0.35);

  // The clock runs by itself until a test takes it over; then frames come when asked for.
  const real = { frame: requestAnimationFrame.bind(window), now: performance.now.bind(performance) };
  let manual = false;
  let now = 0;
  let waiting = [];
  window.requestAnimationFrame = (callback) =>
    manual ? waiting.push(callback) : real.frame((time) => (manual ? waiting.push(callback) : callback(time)));
  performance.now = () => (manual ? now : real.now());


  const hands = {};
  for (const side of ["left", "right"]) {
    const input = device.hands[side];
    input.position.set(0, 0, 0);
    input.quaternion.set(0, 0, 0, 1);
    const spaces = [...input.inputSource.hand.values()];
    hands[side] = { spaces, matrices: null, radii: null };
    const fromIwer = input.updateHandPose.bind(input);
    input.updateHandPose = () => {
      const { matrices, radii } = hands[side];
      if (!matrices) return fromIwer();
      spaces.forEach((space, k) => {
        space[IWER.P_SPACE].offsetMatrix.set(matrices.slice(16 * k, 16 * k + 16));
        space[IWER.P_JOINT_SPACE].radius = radii[k];
      });
    };
  }

  // A joint that is lost has no pose, which the emulator never says of its own accord.
  const lost = new Set();
  const frames = IWER.XRFrame.prototype;
  const { fillPoses, getJointPose } = frames;
  const isLost = (space) => [...lost].some((side) => hands[side].spaces.includes(space));
  frames.fillPoses = function (spaces, base, out) {
    return ![...spaces].some(isLost) && fillPoses.call(this, spaces, base, out);
  };
  frames.getJointPose = function (space, base) {
    return isLost(space) ? null : getJointPose.call(this, space, base);
  };

  // Software rendering of a stereo frame takes far longer than all the rest: draw on request only,
  // and do not wait for the graphics process meanwhile.
  let drawing = true;
  const graphics = WebGL2RenderingContext.prototype;
  for (const name of ["drawElements", "drawArrays", "drawElementsInstanced", "clear"]) {
    const call = graphics[name];
    graphics[name] = function (...given) {
      if (drawing) call.apply(this, given);
    };
  }
  const { getParameter } = graphics;
  const known = new Map();
  graphics.getParameter = function (name) {
    if (drawing || !known.has(name)) known.set(name, getParameter.call(this, name));
    return known.get(name);
  };

  window.headset = {
    device,
    lost,
    takeClock() {
      now = real.now();
      manual = true;
    },
    giveClockBack() {
      manual = false;
      for (const callback of waiting.splice(0)) real.frame(callback);
    },
    /** One frame that is drawn. */
    draw() {
      drawing = true;
      now += 1000 / 72;
      for (const callback of waiting.splice(0)) callback(now);
      drawing = false;
    },
    /** Joints of a relaxed hand, (25, 16), wrist at the origin. */
    relaxed(side) {
      return hands[side].spaces.flatMap((space) => [...space[IWER.P_SPACE].offsetMatrix]);
    },
    /** Frames at 72 Hz, one for each entry {left, right, radius, lost}; calls `each` after it. */
    step(entries, each) {
      const results = [];
      drawing = false;
      for (const entry of entries) {
        for (const side of ["left", "right"]) {
          if (!entry[side]) continue;
          hands[side].matrices = Float32Array.from(entry[side]);
          hands[side].radii = new Array(25).fill(entry.radius ?? 0.008);
        }
        now += 1000 / 72;
        for (const callback of waiting.splice(0)) callback(now);
        if (each) results.push(each());
      }
      return results;
    },
  };
})();
