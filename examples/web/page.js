// SPDX-License-Identifier: Apache-2.0
// The controls of the page, and the timing of draws.
"use strict";

const NAMES = {white: "white", sobol: "Sobol\u2019", blue: "blue"};
const MODES = {sum: "sum", average: "average", camera: "camera moves"};
const MOST = 1024; // sample count at which "no limit" stops, too
const FIRST_LIMIT = 3; // between powers of two, where the samplers differ most
const COLUMNS = 400; // approximate width in pixels; each covers a whole number of screen pixels

const element = id => document.getElementById(id);
const settings = {left: "white", right: "blue", mode: "sum", limit: FIRST_LIMIT};
// catchingUp: an image with fewer samples than shown is rendered from the first sample and shown when it is complete.
let tracer = null, enlarged = 1, paused = false, catchingUp = false, restarts = 0, asked = false;

function fill(name, choices) {
  for (const [value, text] of Object.entries(choices)) {
    const label = document.createElement("label"), input = document.createElement("input");
    const shown = document.createElement("span");
    Object.assign(input, {type: "radio", name, value, checked: settings[name] === value});
    input.addEventListener("change", () => {
      settings[name] = value;
      if (name === "mode") changeMode();
      request();
    });
    shown.textContent = text;
    label.append(input, shown);
    element(name).append(label);
  }
}

/* Sums have a sample count and errors; averages run until they are paused. */
function changeMode() {
  paused = catchingUp = false;
  document.documentElement.classList.toggle("endless", settings.mode !== "sum");
  if (tracer) tracer.restart(tracer.run, settings.mode);
}

/* Shows this many samples per pixel. Samples cannot be removed, so if there are more, rendering starts over. */
function limitTo(count) {
  settings.limit = count;
  paused = false;
  if (tracer && tracer.count > count) {
    tracer.restart(tracer.run);
    catchingUp = true;
  }
  request();
}

/* Changes the samples per pixel by one step, starting from the last step if there was no limit. */
function limitBy(step) {
  limitTo(Math.min(STEPS, Math.max(1, Math.min(settings.limit, STEPS) + step)));
}

const errors = makeErrors(NAMES, limitTo);

function request() {
  if (asked || !tracer) return;
  asked = true;
  requestAnimationFrame(frame);
}

function frame() {
  asked = false;
  if (!tracer) return;
  const limit = settings.mode === "sum" ? settings.limit : Infinity, sigma = Number(element("distance").value), split = Number(element("split").value);
  if (tracer.count < limit && (!paused || tracer.count === 0)) tracer.sample();
  catchingUp = catchingUp && tracer.count < limit;
  if (!catchingUp) tracer.show(settings.left, settings.right, Math.round(split / 100 * tracer.width) * enlarged, sigma, enlarged);

  element("stage").style.setProperty("--split", `${split}%`);
  element("split").setAttribute("aria-valuetext", `${NAMES[settings.left]} to ${split}%, then ${NAMES[settings.right]}`);
  element("left-name").textContent = NAMES[settings.left];
  element("right-name").textContent = NAMES[settings.right];
  element("blur").textContent = sigma ? `${sigma.toFixed(1)} px blur` : "no blur";
  const count = limit === Infinity ? `frame ${tracer.count}` : `${tracer.count} ${tracer.count === 1 ? "sample" : "samples"} per pixel`;
  element("status").textContent = `${tracer.width} \u00d7 ${tracer.height} pixels, ${count}`;
  element("pause").textContent = paused ? "Resume" : "Pause";
  element("pause").disabled = !paused && tracer.count >= limit;
  element("limit").value = Math.min(limit, STEPS);
  element("limit").setAttribute("aria-valuetext", limit > STEPS ? "no limit" : `${limit}`);
  element("shown").textContent = limit > STEPS ? "\u221e" : limit;
  element("endless").checked = limit > STEPS;
  element("less").disabled = limit <= 1;
  element("more").disabled = limit >= STEPS;
  // The errors wait for the image to finish, unless it has no limit. Averages have no errors.
  if (limit < Infinity && tracer.count >= Math.min(limit, STEPS) || paused) errors.step();
  errors.show(limit > STEPS ? tracer.count : limit);
  if (tracer.count < limit && !paused || limit < Infinity && !errors.done) request();
}

/* Fits the image into its area. */
function fit() {
  const canvas = element("picture"), ratio = window.devicePixelRatio || 1;
  const device = Math.max(1, Math.floor(element("stage").clientWidth * ratio));
  const scale = Math.max(1, Math.round(device / COLUMNS));
  const width = Math.ceil(device / scale), height = Math.round(width * 2 / 3);
  if (width === tracer.width && scale === enlarged) return;
  enlarged = scale;
  Object.assign(canvas, {width: width * scale, height: height * scale});
  canvas.style.width = `${width * scale / ratio}px`;
  canvas.style.height = `${height * scale / ratio}px`;
  tracer.resize(width, height);
  errors.restart(tracer);
  request();
}

function moveSplit(event) {
  const stage = element("stage").getBoundingClientRect();
  element("split").value = Math.round(100 * (event.clientX - stage.left) / stage.width);
  request();
}

function start() {
  try {
    tracer = makeTracer(element("picture"));
  } catch (error) {
    element("problem").textContent = `The image cannot be drawn: ${error.message}.`;
    element("problem").hidden = false;
    element("stage").hidden = element("controls").hidden = true;
    return;
  }
  tracer.restart(restarts, settings.mode);
  fit();
}

fill("left", NAMES);
fill("right", NAMES);
fill("mode", MODES);
if (window.self !== window.top) {
  document.documentElement.classList.add("embedded");
  const tell = () => window.parent.postMessage({height: document.documentElement.offsetHeight}, "*");
  new ResizeObserver(tell).observe(document.documentElement);
}
for (const id of ["split", "distance"]) element(id).addEventListener("input", request);
element("pause").addEventListener("click", () => { paused = !paused; request(); });
element("restart").addEventListener("click", () => {
  tracer.restart(++restarts);
  catchingUp = false;
  errors.restart(tracer);
  request();
});
element("limit").addEventListener("input", () => limitTo(Number(element("limit").value)));
element("less").addEventListener("click", () => limitBy(-1));
element("more").addEventListener("click", () => limitBy(1));
element("endless").addEventListener("change", () => limitTo(element("endless").checked ? MOST : STEPS));
element("stage").addEventListener("pointerdown", event => {
  if (event.button !== 0) return;
  event.preventDefault();
  element("split").focus({focusVisible: false, preventScroll: true});
  element("stage").setPointerCapture(event.pointerId);
  moveSplit(event);
});
element("stage").addEventListener("pointermove", event => {
  if (element("stage").hasPointerCapture(event.pointerId)) moveSplit(event);
});
// A device may lose the context and restore it without its contents.
element("picture").addEventListener("webglcontextlost", event => { event.preventDefault(); tracer = null; errors.restart(null); });
element("picture").addEventListener("webglcontextrestored", start);
start();
if (tracer) new ResizeObserver(() => { if (tracer) fit(); }).observe(element("stage"));
