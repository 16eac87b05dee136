// Surfaces in 3-D: turn, zoom, morph from felt to seen, one or several shapes side by side,
// coloured by a field, with a checkerboard that the goal carries along.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("surface-data").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const shorts = (text) => new Uint16Array(bytes(text).buffer);
  const felt = shorts(data.felt), seen = shorts(data.seen), own = shorts(data.virtual);
  const size = data.high.map((h, k) => h - data.low[k]);
  const reach = Math.hypot(...size);
  const short = (x, digits = 2) => Number(x.toPrecision(digits)).toString().replace("-", "−");

  const VERTEX = `#version 300 es
    in vec3 felt; in vec3 seen; in float value;
    uniform mat4 camera; uniform vec3 size; uniform vec3 eye; uniform float morph; uniform float behind;
    out float v; out vec3 place; out vec3 origin;
    void main() {
      place = (mix(felt, seen, morph) - 0.5) * size;
      origin = felt * size;
      v = value;
      gl_Position = camera * vec4(place + behind * normalize(place - eye), 1.0);
    }`;
  const FRAGMENT = `#version 300 es
    precision highp float;
    in float v; in vec3 place; in vec3 origin;
    uniform sampler2D colours; uniform vec3 eye; uniform vec4 ghost; uniform vec4 plain; uniform float square;
    out vec4 colour;
    void main() {
      vec3 n = normalize(cross(dFdx(place), dFdy(place)));
      vec3 toEye = normalize(eye - place);
      if (dot(n, toEye) < 0.0) n = -n;
      vec3 light = normalize(toEye + vec3(0.25, -0.15, 0.75));
      float lit = 0.52 + 0.48 * max(dot(n, light), 0.0);
      float shine = 0.10 * pow(max(dot(n, normalize(light + toEye)), 0.0), 24.0);
      vec3 own = texture(colours, vec2(v * 0.996 + 0.002, 0.5)).rgb;
      if (plain.a > 0.0) own = plain.rgb;
      if (square > 0.0) {
        // cubes of the prop's space, alternately dark: off the origin, so that flat sides that lie
        // on a cube's face do not flicker
        ivec3 cube = ivec3(floor(origin / square + 0.371));
        if (((cube.x + cube.y + cube.z) & 1) == 1) own *= 0.62;
      }
      // of the ghost the silhouette counts, where it is seen at a slant
      float slant = 1.0 - abs(dot(n, toEye));
      colour = ghost.a > 0.0 ? vec4(ghost.rgb, ghost.a * (0.25 + slant * slant)) : vec4(own * lit + shine, 1.0);
    }`;

  // One canvas. `shapes` are the morphs that stand side by side, 0 felt to 1 seen; with one of them,
  // the slider moves it and the virtual object is its ghost.
  const show = (root, given, shapes, square) => {
    const view = root.querySelector(".view");
    const canvas = view.querySelector("canvas");
    const tip = view.querySelector(".tip");
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true, preserveDrawingBuffer: true });
    if (!gl) {
      root.hidden = true;
      return;
    }
    const fields = given.map((f) => ({ ...f, values: bytes(f.values), colours: bytes(f.colours) }));
    const compile = (kind, source) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      return shader;
    };
    const program = gl.createProgram();
    gl.attachShader(program, compile(gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(program);
    gl.useProgram(program);
    const uniform = (name) => gl.getUniformLocation(program, name);

    const attribute = (name, array, kind, width) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
      const at = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, width, kind, true, 0, 0);
      return buffer;
    };
    const prop = gl.createVertexArray(), virtual = gl.createVertexArray();
    gl.bindVertexArray(virtual);
    for (const name of ["felt", "seen"]) attribute(name, own, gl.UNSIGNED_SHORT, 3);
    gl.bindVertexArray(prop);
    attribute("felt", felt, gl.UNSIGNED_SHORT, 3);
    attribute("seen", seen, gl.UNSIGNED_SHORT, 3);
    const valueBuffer = attribute("value", fields[0].values, gl.UNSIGNED_BYTE, 1);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    for (const [key, value] of [
      [gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
    ]) gl.texParameteri(gl.TEXTURE_2D, key, value);
    gl.enable(gl.DEPTH_TEST);

    let field = fields[0], checks = square > 0;
    let turn = -1.05, rise = 0.42, distance = 0.98 * reach;
    let camera = new Float32Array(16), eye = [0, 0, 0], asked = false;

    const choose = (next) => {
      field = next;
      gl.bindBuffer(gl.ARRAY_BUFFER, valueBuffer);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, field.values);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, field.colours);
      const scale = root.querySelector(".scale");
      const bar = scale.querySelector(".bar");
      scale.style.visibility = field.gradient ? "visible" : "hidden";
      bar.style.background = field.gradient;
      bar.replaceChildren();
      const [first, middle, last] = scale.querySelectorAll(".ends span");
      first.textContent = (field.beyond[0] ? "≤ " : "") + short(field.low);
      last.textContent = (field.beyond[1] ? "≥ " : "") + short(field.high) + " " + field.unit;
      middle.textContent = field.name;
      scale.querySelector(".note").textContent = field.note;
      if (field.mark !== null && field.low < field.mark[0] && field.mark[0] < field.high) {
        const [value, what] = field.mark;
        const along = field.log
          ? Math.log(value / field.low) / Math.log(field.high / field.low)
          : (value - field.low) / (field.high - field.low);
        const tick = document.createElement("i");
        tick.style.left = 100 * along + "%";
        tick.title = what;
        bar.append(tick);
        middle.textContent += ", tick: " + what + " " + short(value, 3) + " " + field.unit;
      }
      draw();
    };

    const aim = (aspect) => {
      const [ct, st, cr, sr] = [Math.cos(turn), Math.sin(turn), Math.cos(rise), Math.sin(rise)];
      const back = [ct * cr, st * cr, sr], right = [-st, ct, 0];
      const up = [-ct * sr, -st * sr, cr];
      eye = back.map((b) => b * distance);
      const near = 0.02 * reach, far = 8 * reach, focus = 1.9;
      const wide = aspect > 1 ? 1 : aspect;
      const rows = [
        right.map((c) => (focus * wide * c) / aspect).concat(0),
        up.map((c) => focus * wide * c).concat(0),
      ];
      const depth = (far + near) / (near - far);
      rows.push(back.map((c) => depth * c).concat(-depth * distance + (2 * far * near) / (near - far)));
      rows.push(back.map((c) => -c).concat(distance));
      for (let r = 0; r < 4; r++) for (let c = 0; c < 4; c++) camera[4 * c + r] = rows[r][c];
    };

    const paintShape = (morph) => {
      gl.uniform1f(uniform("morph"), morph);
      gl.uniform4f(uniform("ghost"), 0, 0, 0, 0);
      gl.uniform4f(uniform("plain"), 0, 0, 0, 0);
      gl.uniform1f(uniform("behind"), 0);
      gl.uniform1f(uniform("square"), checks ? square : 0);
      gl.disable(gl.BLEND);
      gl.depthMask(true);
      gl.bindVertexArray(prop);
      gl.drawArrays(gl.TRIANGLES, 0, data.count);
      if (shapes.length > 1) {
        if (morph < 1) return;
        // the virtual object itself, a little behind: it shows where the image leaves it uncovered
        gl.uniform4f(uniform("plain"), 0.85, 0.2, 0.55, 1);
        gl.uniform1f(uniform("behind"), 0.01 * reach);
        gl.uniform1f(uniform("square"), 0);
        gl.bindVertexArray(virtual);
        gl.drawArrays(gl.TRIANGLES, 0, own.length / 3);
        gl.bindVertexArray(prop);
        return;
      }
      // the virtual object as a ghost, until the prop has turned into it
      gl.enable(gl.BLEND);
      gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthMask(false);
      gl.uniform1f(uniform("morph"), 1);
      gl.uniform4f(uniform("ghost"), 0.2, 0.55, 0.8, 0.3 * (1 - morph));
      if (morph < 1) gl.drawArrays(gl.TRIANGLES, 0, data.count);
      gl.depthMask(true);
    };

    const paint = () => {
      asked = false;
      const ratio = Math.min(window.devicePixelRatio || 1, 2);
      const wide = Math.round(canvas.clientWidth * ratio), tall = Math.round(canvas.clientHeight * ratio);
      if (canvas.width !== wide || canvas.height !== tall) { canvas.width = wide; canvas.height = tall; }
      const each = wide / shapes.length;
      aim(each / tall);
      gl.viewport(0, 0, wide, tall);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniformMatrix4fv(uniform("camera"), false, camera);
      gl.uniform3fv(uniform("size"), size);
      gl.uniform3fv(uniform("eye"), eye);
      shapes.forEach((morph, n) => {
        gl.viewport(Math.round(n * each), 0, Math.round(each), tall);
        paintShape(morph);
      });
    };
    const draw = () => { if (!asked) { asked = true; requestAnimationFrame(paint); } };

    // the vertex nearest to the pointer, in front of the others, in the shape that it is over
    const pick = (x, y) => {
      const each = canvas.clientWidth / shapes.length;
      const over = Math.max(0, Math.min(shapes.length - 1, Math.floor(x / each)));
      const right = x - (over + 0.5) * each, up = 0.5 * canvas.clientHeight - y;
      let best = -1, front = Infinity;
      for (let n = 0; n < data.count; n++) {
        const p = [0, 1, 2].map((k) => {
          const at = felt[3 * n + k] + shapes[over] * (seen[3 * n + k] - felt[3 * n + k]);
          return (at / 65535 - 0.5) * size[k];
        });
        const clip = [0, 1, 3].map((r) => camera[r] * p[0] + camera[4 + r] * p[1] + camera[8 + r] * p[2] + camera[12 + r]);
        const dx = (clip[0] / clip[2]) * 0.5 * each - right;
        const dy = (clip[1] / clip[2]) * 0.5 * canvas.clientHeight - up;
        if (dx * dx + dy * dy < 64 && clip[2] < front) { best = n; front = clip[2]; }
      }
      return best;
    };
    const tell = (event) => {
      const box = canvas.getBoundingClientRect();
      const x = event.clientX - box.left, y = event.clientY - box.top;
      const n = field.gradient ? pick(x, y) : -1;
      tip.style.visibility = n < 0 ? "hidden" : "visible";
      if (n < 0) return;
      const t = field.values[n] / 255;
      const value = field.log ? field.low * (field.high / field.low) ** t : field.low + t * (field.high - field.low);
      tip.textContent = `${field.name} ${short(value)} ${field.unit}`;
      tip.style.left = x + "px";
      tip.style.top = y + "px";
    };

    const held = new Map();
    canvas.addEventListener("pointerdown", (e) => {
      canvas.setPointerCapture(e.pointerId);
      held.set(e.pointerId, [e.clientX, e.clientY]);
      tip.style.visibility = "hidden";
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (e) => held.delete(e.pointerId));
    canvas.addEventListener("pointerleave", () => { tip.style.visibility = "hidden"; });
    canvas.addEventListener("pointermove", (e) => {
      if (!held.has(e.pointerId)) { if (e.pointerType === "mouse") tell(e); return; }
      const before = [...held.values()].map((p) => [...p]);
      const [x, y] = held.get(e.pointerId);
      held.set(e.pointerId, [e.clientX, e.clientY]);
      if (held.size === 2) {
        const apart = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);
        zoom(apart(before) / Math.max(apart([...held.values()]), 1));
      } else {
        turn -= 0.008 * (e.clientX - x);
        rise = Math.max(-1.5, Math.min(1.5, rise + 0.008 * (e.clientY - y)));
        draw();
      }
    });
    const zoom = (by) => {
      distance = Math.max(0.5 * reach, Math.min(4 * reach, distance * by));
      draw();
    };
    canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(0.001 * e.deltaY)); }, { passive: false });
    canvas.addEventListener("keydown", (e) => {
      const steps = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
      if (steps[e.key]) {
        e.preventDefault();
        turn += steps[e.key][0];
        rise = Math.max(-1.5, Math.min(1.5, rise + steps[e.key][1]));
        draw();
      } else if (e.key === "+" || e.key === "-") zoom(e.key === "+" ? 0.9 : 1.1);
    });
    for (const input of root.querySelectorAll("input[type=radio]"))
      input.addEventListener("change", () => choose(fields.find((f) => f.key === input.value)));
    root.querySelector(".morph input")?.addEventListener("input", (e) => { shapes[0] = Number(e.target.value); draw(); });
    root.querySelector(".checks-on input")?.addEventListener("change", (e) => { checks = e.target.checked; draw(); });
    new ResizeObserver(draw).observe(canvas);
    choose(field);
  };

  show(document.querySelector(".viewer.contact"), data.fields, [0], 0);
  const map = document.querySelector(".viewer.map");
  if (map) show(map, data.map_fields, [0, 1], data.square);
})();
