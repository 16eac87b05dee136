// Puts an emulated headset, with hands and a clock that tests set, into the unmodified page.
(() => {
  const device = new IWER.XRDevice({ ...IWER.metaQuest3, ...window.headsetOptions });
  device.installRuntime({ forceInstall: true });
  device.primaryInputMode = "hand";
  device.stereoEnabled = true;
  device.position.set(0, 1.2, 0.35);
  device.quaternion.set(-0.3, 0, 0, 0.954); // looking down at the table

  // The clock runs by itself until a test takes it over; then frames come when asked for.
  const real = { frame: requestAnimationFrame.bind(window), now: performance.now.bind(performance) };
  let manual = false;
  let now = 0;
  let waiting = [];
  let due = 0; // frames that the browser still owes
  window.requestAnimationFrame = (callback) => {
    if (manual) return waiting.push(callback);
    due++;
    return real.frame((time) => {
      due--;
      if (manual) waiting.push(callback);
      else callback(time);
    });
  };
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

  // The emulator knows of no bounds: those of a test, with the frame that they are given in.
  const { bounds } = window.headsetOptions;
  const sessions = IWER.XRSession.prototype;
  const { requestReferenceSpace } = sessions;
  sessions.requestReferenceSpace = async function (type) {
    const space = await requestReferenceSpace.call(this, type);
    if (type === "bounded-floor" && bounds) {
      space[IWER.P_SPACE].offsetMatrix.set(bounds.matrix);
      space.boundsGeometry = bounds.outline.map(([x, z]) => new DOMPointReadOnly(x, 0, z, 1));
    }
    return space;
  };

  // A controller that is fixed to a prop, which this emulator does not track beside hands.
  const controller = device.controllers.left.inputSource;
  Object.defineProperty(sessions, "trackedSources", {
    get() {
      if (!window.headset.grip) return [];
      const space = controller.gripSpace[IWER.P_SPACE];
      space.offsetMatrix.set(window.headset.grip);
      space.emulated = false; // it is truly seen
      return [controller];
    },
  });

  // The emulator tells `select` as a pinch closes; a headset tells it as one opens, before `selectend`.
  const { dispatchEvent } = sessions;
  sessions.dispatchEvent = function (event) {
    if (event.type === "select") return true;
    if (event.type === "selectend") dispatchEvent.call(this, new event.constructor("select", event));
    return dispatchEvent.call(this, event);
  };

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
  let drawing = false;
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

  // Wrist, thumb, four fingers; the tips are what tests compute with.
  const RADII = [0.02, 0.014, 0.012, 0.01, 0.008, ...Array(4).fill([0.014, 0.011, 0.0095, 0.009, 0.008])].flat();

  window.headset = {
    device,
    lost,
    /** T_room_grip of the controller that is fixed to a prop, column-major; null while none is tracked. */
    grip: null,
    /** The real clock, ms. */
    now: real.now,
    takeClock() {
      now = real.now();
      manual = true;
    },
    /** Whether all that waits for a frame waits for this clock's. */
    hasClock: () => manual && due === 0,
    giveClockBack() {
      manual = false;
      for (const callback of waiting.splice(0)) requestAnimationFrame(callback);
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
    /** Frames at 72 Hz: float32 joint matrices, base64, 400 numbers a hand, left hand first; a NaN
     * leaves a hand as it was. Calls `each` after every frame. */
    step(packed, each) {
      const letters = atob(packed);
      const bytes = new Uint8Array(letters.length); // one by one: from() takes ten times as long
      for (let k = 0; k < bytes.length; k++) bytes[k] = letters.charCodeAt(k);
      const numbers = new Float32Array(bytes.buffer);
      const results = [];
      for (let start = 0; start < numbers.length; start += 800) {
        ["left", "right"].forEach((side, k) => {
          const first = start + 400 * k;
          if (Number.isNaN(numbers[first])) return;
          hands[side].matrices = numbers.slice(first, first + 400);
          hands[side].radii = RADII;
        });
        now += 1000 / 72;
        for (const callback of waiting.splice(0)) callback(now);
        if (each) results.push(each());
      }
      return results;
    },
  };
})();
