// The props' surfaces in 3-D: turn, zoom, morph from felt to seen, colour by a field.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("surface-data").textContent);
  const view = document.querySelector(".view");
  const canvas = view.querySelector("canvas");
  const tip = view.querySelector(".tip");
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true, preserveDrawingBuffer: true });
  if (!gl) {
    document.querySelector(".viewer").hidden = true;
    return;
  }

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const felt = new Uint16Array(bytes(data.felt).buffer);
  const seen = new Uint16Array(bytes(data.seen).buffer);
  const fields = data.fields.map((f) => ({ ...f, values: bytes(f.values), colours: bytes(f.colours) }));
  const size = data.high.map((h, k) => h - data.low[k]);
  const reach = Math.hypot(...size);

  const compile = (kind, source) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    return shader;
  };
  const program = gl.createProgram();
  gl.attachShader(program, compile(gl.VERTEX_SHADER, `#version 300 es
    in vec3 felt; in vec3 seen; in float value;
    uniform mat4 camera; uniform vec3 size; uniform float morph;
    out float v; out vec3 place;
    void main() {
      place = (mix(felt, seen, morph) - 0.5) * size;
      v = value;
      gl_Position = camera * vec4(place, 1.0);
    }`));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, `#version 300 es
    precision highp float;
    in float v; in vec3 place;
    uniform sampler2D colours; uniform vec3 eye; uniform vec4 ghost;
    out vec4 colour;
    void main() {
      vec3 n = normalize(cross(dFdx(place), dFdy(place)));
      vec3 toEye = normalize(eye - place);
      if (dot(n, toEye) < 0.0) n = -n;
      vec3 light = normalize(toEye + vec3(0.25, -0.15, 0.75));
      float lit = 0.52 + 0.48 * max(dot(n, light), 0.0);
      float shine = 0.10 * pow(max(dot(n, normalize(light + toEye)), 0.0), 24.0);
      vec3 own = texture(colours, vec2(v * 0.996 + 0.002, 0.5)).rgb * lit + shine;
      // of the ghost the silhouette counts, where it is seen at a slant
      float slant = 1.0 - abs(dot(n, toEye));
      colour = ghost.a > 0.0 ? vec4(ghost.rgb, ghost.a * (0.25 + slant * slant)) : vec4(own, 1.0);
    }`));
  gl.linkProgram(program);
  gl.useProgram(program);

  const attribute = (name, array, kind, width) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
    const at = gl.getAttribLocation(program, name);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, width, kind, true, 0, 0);
    return buffer;
  };
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

  let field = fields[0];
  let turn = -1.05, rise = 0.42, distance = 0.98 * reach, morph = 0;
  let camera = new Float32Array(16), eye = [0, 0, 0], asked = false;

  const choose = (next) => {
    field = next;
    gl.bindBuffer(gl.ARRAY_BUFFER, valueBuffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, field.values);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, field.colours);
    const scale = document.querySelector(".scale");
    const bar = scale.querySelector(".bar");
    bar.style.background = field.gradient;
    bar.replaceChildren();
    const [first, middle, last] = scale.querySelectorAll(".ends span");
    const short = (x) => Number(x.toPrecision(2)).toString();
    first.textContent = (field.log ? "≤ " : "") + short(field.low);
    last.textContent = (field.log ? "≥ " : "") + short(field.high) + " " + field.unit;
    middle.textContent = field.name;
    if (field.mark !== null) {
      const tick = document.createElement("i");
      tick.style.left = 100 * Math.log(field.mark / field.low) / Math.log(field.high / field.low) + "%";
      tick.title = "tolerance";
      bar.append(tick);
      middle.textContent += ", tick: tolerance " + short(field.mark) + " " + field.unit;
    }
    draw();
  };

  const aim = () => {
    const [ct, st, cr, sr] = [Math.cos(turn), Math.sin(turn), Math.cos(rise), Math.sin(rise)];
    const back = [ct * cr, st * cr, sr], right = [-st, ct, 0];
    const up = [-ct * sr, -st * sr, cr];
    eye = back.map((b) => b * distance);
    const near = 0.02 * reach, far = 8 * reach, focus = 1.9;
    const aspect = canvas.width / canvas.height;
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

  const paint = () => {
    asked = false;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const wide = Math.round(canvas.clientWidth * ratio), tall = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== wide || canvas.height !== tall) { canvas.width = wide; canvas.height = tall; }
    gl.viewport(0, 0, wide, tall);
    aim();
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(gl.getUniformLocation(program, "camera"), false, camera);
    gl.uniform3fv(gl.getUniformLocation(program, "size"), size);
    gl.uniform3fv(gl.getUniformLocation(program, "eye"), eye);
    gl.uniform1f(gl.getUniformLocation(program, "morph"), morph);
    gl.uniform4f(gl.getUniformLocation(program, "ghost"), 0, 0, 0, 0);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.drawArrays(gl.TRIANGLES, 0, data.count);
    // the virtual object as a ghost, until the prop has turned into it
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.uniform1f(gl.getUniformLocation(program, "morph"), 1);
    gl.uniform4f(gl.getUniformLocation(program, "ghost"), 0.2, 0.55, 0.8, 0.3 * (1 - morph));
    if (morph < 1) gl.drawArrays(gl.TRIANGLES, 0, data.count);
    gl.depthMask(true);
  };
  const draw = () => { if (!asked) { asked = true; requestAnimationFrame(paint); } };

  // the vertex nearest to the pointer, in front of the others
  const pick = (x, y) => {
    let best = -1, front = Infinity;
    for (let n = 0; n < data.count; n++) {
      const p = [0, 1, 2].map((k) => {
        const at = felt[3 * n + k] + morph * (seen[3 * n + k] - felt[3 * n + k]);
        return (at / 65535 - 0.5) * size[k];
      });
      const clip = [0, 1, 3].map((r) => camera[r] * p[0] + camera[4 + r] * p[1] + camera[8 + r] * p[2] + camera[12 + r]);
      const dx = (clip[0] / clip[2]) * 0.5 * canvas.clientWidth - x;
      const dy = (clip[1] / clip[2]) * 0.5 * canvas.clientHeight - y;
      if (dx * dx + dy * dy < 64 && clip[2] < front) { best = n; front = clip[2]; }
    }
    return best;
  };
  const tell = (event) => {
    const box = canvas.getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    const n = pick(x - box.width / 2, box.height / 2 - y);
    tip.style.visibility = n < 0 ? "hidden" : "visible";
    if (n < 0) return;
    const t = field.values[n] / 255;
    const value = field.log ? field.low * (field.high / field.low) ** t : field.low + t * (field.high - field.low);
    tip.textContent = `${field.name} ${Number(value.toPrecision(2))} ${field.unit}`;
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
  for (const input of document.querySelectorAll("input[name=field]"))
    input.addEventListener("change", () => choose(fields.find((f) => f.key === input.value)));
  document.querySelector(".morph input").addEventListener("input", (e) => { morph = Number(e.target.value); draw(); });
  new ResizeObserver(draw).observe(canvas);
  choose(field);
})();
