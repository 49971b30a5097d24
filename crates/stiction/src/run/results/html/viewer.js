// The interactive view: decodes the arrays of #view-data and draws them with WebGL 1. No library, no network.
(function () {
"use strict";
var root = document.documentElement;
function get(id) { return document.getElementById(id); }
function without(why) {
  root.setAttribute("data-viewer", "none");
  get("viewer").hidden = true;
  get("viewer-missing").hidden = false;
  get("viewer-missing").textContent = why + " The pictures below show the result.";
}
window.addEventListener("error", function (e) { root.setAttribute("data-error", String(e.message)); });

// ---- what is shown
var data = JSON.parse(get("view-data").textContent);
function bytes(text) {
  var raw = atob(text), out = new Uint8Array(raw.length);
  for (var i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}
var n = data.points, STEPS = 65534, SIGNED = 32767;
var centre = [0, 1, 2].map(function (c) { return (data.low[c] + data.high[c]) / 2; });
var radius = 0.5 * Math.hypot(data.high[0] - data.low[0], data.high[1] - data.low[1], data.high[2] - data.low[2]) || 1;
var place = (function () {
  var code = new Uint16Array(bytes(data.position)), out = new Float32Array(3 * n);
  for (var i = 0; i < 3 * n; i++) {
    var c = i % 3;
    out[i] = (data.low[c] - centre[c] + code[i] / STEPS * (data.high[c] - data.low[c])) / radius;
  }
  return out;
})();
var faces = data.indexBytes === 2 ? new Uint16Array(bytes(data.faces)) : new Uint32Array(bytes(data.faces));
var frames = data.frames.map(function (f) {
  var code = new Int16Array(bytes(f.displacement)), shift = new Float32Array(3 * n), largest = 0;
  for (var i = 0; i < 3 * n; i++) shift[i] = code[i] / SIGNED * f.largest;
  for (var v = 0; v < n; v++) largest = Math.max(largest, Math.hypot(shift[3 * v], shift[3 * v + 1], shift[3 * v + 2]));
  return { name: f.name, shift: shift, largest: largest, values: f.values };
});
function decoded(field) { // numbers of a stored field, NaN where there is none
  var code = new Uint16Array(bytes(field.data)), out = new Float32Array(n);
  for (var i = 0; i < n; i++) out[i] = code[i] > STEPS ? NaN : field.low + code[i] / STEPS * (field.high - field.low);
  return out;
}
function component(c) {
  return function (f) {
    var out = new Float32Array(n), u = frames[f].shift;
    for (var v = 0; v < n; v++) out[v] = c < 3 ? u[3 * v + c] : Math.hypot(u[3 * v], u[3 * v + 1], u[3 * v + 2]);
    return out;
  };
}
var kept = {};
var fields = [[3, "Displacement, size"], [0, "Displacement along x"], [1, "Displacement along y"], [2, "Displacement along z"]]
  .map(function (d) { return { label: d[1], unit: data.length, status: false, contact: false, values: component(d[0]) }; });
data.fields.forEach(function (f, i) {
  fields.push({ label: f.label, unit: f.unit, status: f.status, contact: i > 0, values: function (k) {
    var key = i + "/" + k;
    return kept[key] || (kept[key] = decoded(frames[k].values[i]));
  } });
});
function range(field) { // over all frames, so that steps can be compared; from zero if all have one sign
  if (!field.range) {
    var low = 0, high = 0;
    frames.forEach(function (_, k) {
      field.values(k).forEach(function (x) { if (x < low) low = x; if (x > high) high = x; });
    });
    field.range = [low, high > low ? high : low + 1];
  }
  return field.range;
}

// ---- WebGL
var canvas = get("canvas");
var gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
if (!gl) return without("This browser does not offer WebGL.");
var slopes = gl.getExtension("OES_standard_derivatives");
if (data.indexBytes === 4 && !gl.getExtension("OES_element_index_uint"))
  return without("This browser's WebGL cannot number so many points.");
var VERTEX = "attribute vec3 place, shift; attribute vec4 value; uniform mat3 turn; uniform vec3 window; uniform vec2 pan;" +
  "uniform float scale, lift; varying vec4 v; varying vec3 at; void main() { v = value; at = turn * (place + scale * shift);" +
  "gl_Position = vec4((at.xy - pan) * window.xy, -at.z * window.z - lift, 1.0); }";
var HEAD = (slopes ? "#extension GL_OES_standard_derivatives : enable\n" : "") +
  "#ifdef GL_FRAGMENT_PRECISION_HIGH\nprecision highp float;\n#else\nprecision mediump float;\n#endif\n";
var SURFACE = HEAD + "varying vec4 v; varying vec3 at; uniform sampler2D map; uniform bool status; uniform float alpha;" +
  "uniform vec3 states[4]; uniform vec3 none; void main() { vec3 c = none;" +
  "if (status) { float m = max(max(v.x, v.y), max(v.z, v.w)); if (v.x + v.y + v.z + v.w > 0.5)" +
  "c = v.x >= m ? states[0] : v.y >= m ? states[1] : v.z >= m ? states[2] : states[3]; }" +
  "else if (v.y > 0.99) c = texture2D(map, vec2((v.x * 255.0 + 0.5) / 256.0, 0.5)).rgb; float light = 1.0;" +
  (slopes ? "vec3 n = normalize(cross(dFdx(at), dFdy(at))); light = 0.6 + 0.4 * abs(dot(n, vec3(0.32, 0.42, 0.85)));" : "") +
  "gl_FragColor = vec4(c * light * alpha, alpha); }";
var LINES = HEAD + "varying vec4 v; varying vec3 at; uniform vec4 ink; void main() { gl_FragColor = vec4(ink.rgb * ink.a, ink.a); }";
function program(fragment) {
  var p = gl.createProgram();
  [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment]].forEach(function (s) {
    var shader = gl.createShader(s[0]);
    gl.shaderSource(shader, s[1]);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(p, shader);
  });
  ["place", "shift", "value"].forEach(function (name, i) { gl.bindAttribLocation(p, i, name); });
  gl.linkProgram(p);
  if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(p));
  var at = {};
  for (var i = 0, count = gl.getProgramParameter(p, gl.ACTIVE_UNIFORMS); i < count; i++) {
    var name = gl.getActiveUniform(p, i).name.replace("[0]", "");
    at[name] = gl.getUniformLocation(p, name);
  }
  return { p: p, at: at };
}
var surface, lines;
try { surface = program(SURFACE); lines = program(LINES); } catch (e) { return without("WebGL fails here (" + e.message + ")."); }
function fill(buffer, kind, array) {
  gl.bindBuffer(kind, buffer);
  gl.bufferData(kind, array, gl.DYNAMIC_DRAW);
  return buffer;
}
var Index = data.indexBytes === 2 ? Uint16Array : Uint32Array;
var indexType = data.indexBytes === 2 ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT;
var buffers = [gl.createBuffer(), gl.createBuffer(), gl.createBuffer()];
fill(buffers[0], gl.ARRAY_BUFFER, place);
function indices(from, to) { // triangles and edges of some of the faces
  var triangles = [], edges = [], known = new Set();
  for (var f = 4 * from; f < 4 * to; f += 4) {
    triangles.push(faces[f], faces[f + 1], faces[f + 2]);
    var four = faces[f + 2] !== faces[f + 3];
    if (four) triangles.push(faces[f], faces[f + 2], faces[f + 3]);
    for (var i = 0, k = four ? 4 : 3; i < k; i++) {
      var a = faces[f + i], b = faces[f + (i + 1) % k], key = a < b ? a * n + b : b * n + a;
      if (!known.has(key)) { known.add(key); edges.push(a, b); }
    }
  }
  return {
    triangles: fill(gl.createBuffer(), gl.ELEMENT_ARRAY_BUFFER, new Index(triangles)), triangleCount: triangles.length,
    edges: fill(gl.createBuffer(), gl.ELEMENT_ARRAY_BUFFER, new Index(edges)), edgeCount: edges.length
  };
}
var body = indices(0, data.firstContactFace), contact = indices(data.firstContactFace, faces.length / 4);
var map = gl.createTexture(), texels = new Uint8Array(256 * 3);
data.map.forEach(function (c, i) { texels.set(c, 3 * i); });
gl.bindTexture(gl.TEXTURE_2D, map);
gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, texels);
[[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
  [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]].forEach(function (p) { gl.texParameteri(gl.TEXTURE_2D, p[0], p[1]); });

// ---- state
var largest = Math.max.apply(null, frames.map(function (f) { return f.largest; }));
function round125(x) {
  var p = Math.pow(10, Math.floor(Math.log10(x)));
  return (x / p < 2 ? 1 : x / p < 5 ? 2 : 5) * p;
}
var usual = largest > 0 ? Math.max(round125(0.16 * radius / largest), 1e-12) : 1;
var state = { frame: frames.length - 1, field: 0, show: "all", lines: data.firstContactFace < 20000, scale: usual,
  azimuth: -Math.PI / 3, elevation: 0.45, zoom: 1, pan: [0, 0] };
var chosen = false; // whether the reader has chosen what to show
var value = new Float32Array(4 * n), now = null;

function setValues() {
  var field = fields[state.field], span = range(field);
  now = field.values(state.frame);
  for (var v = 0; v < n; v++) {
    var x = now[v], at = 4 * v;
    value[at] = value[at + 1] = value[at + 2] = value[at + 3] = 0;
    if (isNaN(x)) continue;
    if (field.status) value[at + (x < -0.5 ? 3 : Math.round(x))] = 1;
    else { value[at] = (x - span[0]) / (span[1] - span[0]); value[at + 1] = 1; }
  }
  fill(buffers[2], gl.ARRAY_BUFFER, value);
}
function setShift() {
  var out = new Float32Array(3 * n), u = frames[state.frame].shift;
  for (var i = 0; i < 3 * n; i++) out[i] = u[i] / radius;
  fill(buffers[1], gl.ARRAY_BUFFER, out);
}
function turn() { // rows: to the right, up, towards the eye
  var ca = Math.cos(state.azimuth), sa = Math.sin(state.azimuth), ce = Math.cos(state.elevation), se = Math.sin(state.elevation);
  return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
}
function win() { // from model to window
  var s = 0.92 * state.zoom, w = canvas.width, h = canvas.height;
  return w > h ? [s * h / w, s, 0.1] : [s, s * w / h, 0.1];
}
function draw() {
  pending = false;
  var dark = getComputedStyle(root).colorScheme.indexOf("dark") >= 0 && matchMedia("(prefers-color-scheme: dark)").matches;
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  [3, 3, 4].forEach(function (size, i) {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers[i]);
    gl.enableVertexAttribArray(i);
    gl.vertexAttribPointer(i, size, gl.FLOAT, false, 0, 0);
  });
  var t = turn(), columns = [0, 1, 2].map(function (c) { return [t[0][c], t[1][c], t[2][c]]; });
  function common(p, lift) {
    gl.useProgram(p.p);
    gl.uniformMatrix3fv(p.at.turn, false, new Float32Array([].concat.apply([], columns)));
    gl.uniform3fv(p.at.window, win());
    gl.uniform2fv(p.at.pan, state.pan);
    gl.uniform1f(p.at.scale, state.scale);
    gl.uniform1f(p.at.lift, lift);
  }
  function part(which, alpha, ink) {
    common(surface, 0);
    gl.uniform1i(surface.at.status, fields[state.field].status ? 1 : 0);
    gl.uniform1f(surface.at.alpha, alpha);
    gl.uniform3fv(surface.at.none, [0.78, 0.78, 0.78]);
    gl.uniform3fv(surface.at.states, [].concat.apply([], data.states.map(function (s) { return s[1]; })).map(function (c) { return c / 255; }));
    gl.depthMask(alpha === 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, which.triangles);
    gl.drawElements(gl.TRIANGLES, which.triangleCount, indexType, 0);
    if (!ink) return;
    common(lines, 3e-4);
    gl.uniform4fv(lines.at.ink, alpha === 1 ? [0.05, 0.05, 0.05, ink] : dark ? [0.9, 0.9, 0.9, 0.18] : [0.1, 0.1, 0.1, 0.14]);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, which.edges);
    gl.drawElements(gl.LINES, which.edgeCount, indexType, 0);
  }
  var ink = state.lines ? 0.35 : 0;
  part(contact, 1, ink);
  if (state.show === "all") part(body, 1, ink);
  if (state.show === "through") part(body, 0.12, state.lines ? 1 : 0);
  gl.depthMask(true);
  axes(t);
  root.setAttribute("data-viewer", "ready");
}
var pending = false;
function redraw() { if (!pending) { pending = true; requestAnimationFrame(draw); } }
function resize() {
  var ratio = window.devicePixelRatio || 1;
  var w = Math.max(1, Math.round(canvas.clientWidth * ratio)), h = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  redraw();
}
function axes(t) {
  ["x", "y", "z"].forEach(function (name, c) {
    var dx = 26 * t[0][c], dy = -26 * t[1][c], line = get("axis-" + name), label = get("label-" + name);
    line.setAttribute("x2", 40 + dx);
    line.setAttribute("y2", 40 + dy);
    label.setAttribute("x", 40 + 1.35 * dx);
    label.setAttribute("y", 40 + 1.35 * dy);
  });
}

// ---- words beside the picture
function short(x) {
  if (!isFinite(x)) return "none";
  var size = Math.abs(x), text = size !== 0 && (size < 1e-3 || size >= 1e5) ? x.toExponential(3) : String(parseFloat(x.toPrecision(4)));
  return text.replace(/\.?0+e/, "e").replace("e+", "e");
}
function withUnit(x, unit) { return short(x) + (unit ? " " + unit : ""); }
function bar() {
  var field = fields[state.field], span = range(field), box = get("bar");
  get("bar-title").textContent = field.label + (field.unit ? " [" + field.unit + "]" : "");
  box.textContent = "";
  box.className = field.status ? "legend" : "scale";
  function add(tag, style, text) {
    var e = document.createElement(tag);
    if (style) e.setAttribute("style", style);
    e.textContent = text || "";
    box.appendChild(e);
    return e;
  }
  if (field.status) {
    data.states.forEach(function (s) { add("span", "--swatch: rgb(" + s[1].join(",") + ")", s[0]).className = "state"; });
  } else {
    var stops = data.map.filter(function (_, i) { return i % 15 === 0; }).map(function (c) { return "rgb(" + c.join(",") + ")"; });
    add("div", "background: linear-gradient(to right," + stops.join(",") + ")").className = "ramp";
    for (var i = 0; i <= 4; i++) add("span", "left:" + 25 * i + "%", short(parseFloat((span[0] + (span[1] - span[0]) * i / 4).toPrecision(3)))).className = "tick";
  }
  get("bar-note").textContent = field.contact ? "grey: not a contact point" : field.label.indexOf("Mises") >= 0 ? "mean of the cells at each node" : "";
}
function update() {
  setValues();
  bar();
  get("deformation").value = Math.min(state.scale / (3 * usual), 1) * 1000;
  get("factor").value = parseFloat(state.scale.toPrecision(4));
  var frame = get("frame-name");
  if (frame) frame.textContent = frames[state.frame].name;
  redraw();
}

// ---- what the reader does
var select = get("field");
fields.forEach(function (f, i) { select.add(new Option(f.label, i)); });
if (data.firstContactFace * 4 === faces.length) get("show-choice").hidden = true;
select.onchange = function () {
  state.field = +select.value;
  if (!chosen) get("show").value = state.show = fields[state.field].contact ? "through" : "all";
  update();
};
get("show").onchange = function () { chosen = true; state.show = this.value; redraw(); };
get("deformation").oninput = function () { state.scale = this.value / 1000 * 3 * usual; update(); };
get("factor").onchange = function () { var x = parseFloat(this.value); if (isFinite(x)) state.scale = x; update(); };
get("lines").checked = state.lines;
get("lines").onchange = function () { state.lines = this.checked; redraw(); };
var step = get("frame");
if (step) step.oninput = function () { state.frame = +step.value; setShift(); update(); };
var VIEWS = { iso: [-Math.PI / 3, 0.45], below: [-Math.PI / 3, -0.6], x: [0, 0], y: [-Math.PI / 2, 0], z: [-Math.PI / 2, Math.PI / 2] };
document.querySelectorAll("[data-view]").forEach(function (b) {
  b.onclick = function () {
    var view = VIEWS[b.getAttribute("data-view")];
    if (view) { state.azimuth = view[0]; state.elevation = view[1]; }
    fit();
  };
});
function fit() { // what is shown of the deformed body fills the window
  var t = turn(), low = [1e9, 1e9], high = [-1e9, -1e9], u = frames[state.frame].shift;
  for (var v = state.show === "contact" ? data.firstContactPoint : 0; v < n; v++) for (var k = 0; k < 2; k++) {
    var x = 0;
    for (var c = 0; c < 3; c++) x += t[k][c] * (place[3 * v + c] + state.scale * u[3 * v + c] / radius);
    if (x < low[k]) low[k] = x;
    if (x > high[k]) high[k] = x;
  }
  state.pan = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  state.zoom = 1;
  var w = win();
  state.zoom = Math.min(1.8 / ((high[0] - low[0]) * w[0] || 1), 1.8 / ((high[1] - low[1]) * w[1] || 1));
  redraw();
}
var held = {}, last = null;
function zoomAt(factor, x, y) { // keeps what is under the pointer where it is
  var box = canvas.getBoundingClientRect(), w = win();
  var px = (2 * (x - box.left) / box.width - 1) / w[0], py = (1 - 2 * (y - box.top) / box.height) / w[1];
  var z = Math.min(Math.max(state.zoom * factor, 0.05), 500);
  factor = z / state.zoom;
  state.pan = [state.pan[0] + px * (1 - 1 / factor), state.pan[1] + py * (1 - 1 / factor)];
  state.zoom = z;
  redraw();
}
function shiftBy(dx, dy) {
  var box = canvas.getBoundingClientRect(), w = win();
  state.pan = [state.pan[0] - 2 * dx / box.width / w[0], state.pan[1] + 2 * dy / box.height / w[1]];
  redraw();
}
function rotate(dx, dy) {
  state.azimuth -= 0.008 * dx;
  state.elevation = Math.min(Math.max(state.elevation + 0.008 * dy, -Math.PI / 2), Math.PI / 2);
  redraw();
}
function spread() {
  var p = Object.keys(held).map(function (k) { return held[k]; });
  return p.length < 2 ? null : { d: Math.hypot(p[0].x - p[1].x, p[0].y - p[1].y), x: (p[0].x + p[1].x) / 2, y: (p[0].y + p[1].y) / 2 };
}
canvas.onpointerdown = function (e) {
  canvas.setPointerCapture(e.pointerId);
  held[e.pointerId] = { x: e.clientX, y: e.clientY };
  last = spread();
  canvas.focus({ preventScroll: true });
};
canvas.onpointermove = function (e) {
  var was = held[e.pointerId];
  if (!was) return probe(e);
  var dx = e.clientX - was.x, dy = e.clientY - was.y;
  held[e.pointerId] = { x: e.clientX, y: e.clientY };
  var two = spread();
  if (two && last) {
    zoomAt(two.d / (last.d || 1), two.x, two.y);
    shiftBy(two.x - last.x, two.y - last.y);
    last = two;
  } else if (e.shiftKey || e.buttons > 1) shiftBy(dx, dy); else rotate(dx, dy);
};
canvas.onpointerup = canvas.onpointercancel = function (e) { delete held[e.pointerId]; last = spread(); };
canvas.onpointerleave = function () { get("dot").hidden = true; };
canvas.oncontextmenu = function () { return false; };
canvas.ondblclick = fit;
canvas.addEventListener("wheel", function (e) {
  e.preventDefault();
  zoomAt(Math.exp(-0.0015 * e.deltaY * (e.deltaMode === 1 ? 30 : 1)), e.clientX, e.clientY);
}, { passive: false });
canvas.onkeydown = function (e) {
  var box = canvas.getBoundingClientRect(), x = box.left + box.width / 2, y = box.top + box.height / 2;
  var act = { ArrowLeft: [rotate, -20, 0], ArrowRight: [rotate, 20, 0], ArrowUp: [rotate, 0, -20], ArrowDown: [rotate, 0, 20],
    "+": [zoomAt, 1.2, x, y], "-": [zoomAt, 1 / 1.2, x, y], "0": [fit] }[e.key];
  if (act) { e.preventDefault(); act[0].apply(null, act.slice(1)); }
};
function probe(e) { // the vertex under the pointer: near it, and near the eye
  var box = canvas.getBoundingClientRect(), t = turn(), w = win(), u = frames[state.frame].shift, best = -1, least = 1e9;
  var from = state.show === "all" ? 0 : data.firstContactPoint, at = [0, 0];
  for (var v = from; v < n; v++) {
    var p = [0, 1, 2].map(function (k) {
      var x = 0;
      for (var c = 0; c < 3; c++) x += t[k][c] * (place[3 * v + c] + state.scale * u[3 * v + c] / radius);
      return x;
    });
    var x = box.width * ((p[0] - state.pan[0]) * w[0] + 1) / 2, y = box.height * (1 - (p[1] - state.pan[1]) * w[1]) / 2;
    var away = Math.hypot(x - e.clientX + box.left, y - e.clientY + box.top), cost = 0.004 * away - p[2];
    if (away < 14 && cost < least) { least = cost; best = v; at = [x, y]; }
  }
  var dot = get("dot"), words = get("probe");
  dot.hidden = best < 0;
  if (best < 0) return void (words.textContent = HINT);
  dot.style.left = at[0] + "px";
  dot.style.top = at[1] + "px";
  var x = [0, 1, 2].map(function (c) { return short(centre[c] + radius * place[3 * best + c]); });
  var told = fields.filter(function (f) { return !f.contact || best >= data.firstContactPoint; }).map(function (f) {
    var x = f.values(state.frame)[best];
    var state_ = f.status ? data.states[x < -0.5 ? 3 : Math.round(x)] : null;
    return f.label + " " + (f.status ? (state_ ? state_[0] : "none") : withUnit(x, f.unit));
  });
  words.textContent = "(" + x.join(", ") + ")" + (data.length ? " " + data.length : "") + ": " + told.join("; ");
}
var HINT = "Drag turns, right button or Shift moves, the wheel zooms, a double click fits; point at the body to read values.";
get("probe").textContent = HINT;
window.addEventListener("resize", resize);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
canvas.addEventListener("webglcontextlost", function () { without("The graphics processor has given up the view."); });
setShift();
resize();
update();
fit();
})();
