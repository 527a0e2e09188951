// SPDX-License-Identifier: Apache-2.0
// The controls of the page, and when to draw.
"use strict";

const NAMES = {white: "white", sobol: "Sobol\u2019", blue: "blue"};
const MOST = 1024; // samples after which "no limit" rests, too
const LIMITS = {1: "1", 2: "2", 4: "4", 16: "16", [MOST]: "no limit"};
const COLUMNS = 400; // about as many pixels to a row; each is a whole number of the screen's

const element = id => document.getElementById(id);
const settings = {left: "white", right: "blue", limit: "1"};
let tracer = null, enlarged = 1, paused = false, restarts = 0, asked = false;

function fill(name, choices) {
  for (const [value, text] of Object.entries(choices)) {
    const label = document.createElement("label"), input = document.createElement("input");
    const shown = document.createElement("span");
    Object.assign(input, {type: "radio", name, value, checked: settings[name] === value});
    input.addEventListener("change", () => {
      settings[name] = value;
      // More samples than the new limit cannot be taken back.
      if (name === "limit" && tracer.count > Number(value)) tracer.restart(tracer.run);
      request();
    });
    shown.textContent = text;
    label.append(input, shown);
    element(name).append(label);
  }
}

function request() {
  if (asked || !tracer) return;
  asked = true;
  requestAnimationFrame(frame);
}

function frame() {
  asked = false;
  if (!tracer) return;
  const limit = Number(settings.limit), sigma = Number(element("distance").value), split = Number(element("split").value);
  if (tracer.count < limit && (!paused || tracer.count === 0)) tracer.sample();
  tracer.show(settings.left, settings.right, Math.round(split / 100 * tracer.width) * enlarged, sigma, enlarged);

  element("stage").style.setProperty("--split", `${split}%`);
  element("split").setAttribute("aria-valuetext", `${NAMES[settings.left]} to ${split} %, then ${NAMES[settings.right]}`);
  element("left-name").textContent = NAMES[settings.left];
  element("right-name").textContent = NAMES[settings.right];
  element("blur").textContent = sigma ? `${sigma.toFixed(1)} px blur` : "no blur";
  const count = `${tracer.count} ${tracer.count === 1 ? "sample" : "samples"} per pixel`;
  element("status").textContent = `${tracer.width} \u00d7 ${tracer.height} pixels, ${count}`;
  element("pause").textContent = paused ? "Resume" : "Pause";
  element("pause").disabled = !paused && tracer.count >= limit;
  if (tracer.count < limit && !paused) request();
}

/* Fits the picture into its place. */
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
    element("problem").textContent = `The picture cannot be drawn: ${error.message}.`;
    element("problem").hidden = false;
    element("stage").hidden = element("controls").hidden = true;
    return;
  }
  tracer.restart(restarts);
  fit();
}

fill("left", NAMES);
fill("right", NAMES);
fill("limit", LIMITS);
if (window.self !== window.top) document.documentElement.classList.add("embedded");
for (const id of ["split", "distance"]) element(id).addEventListener("input", request);
element("pause").addEventListener("click", () => { paused = !paused; request(); });
element("restart").addEventListener("click", () => { tracer.restart(++restarts); request(); });
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
// A device may take the context away, and give it back without its contents.
element("picture").addEventListener("webglcontextlost", event => { event.preventDefault(); tracer = null; });
element("picture").addEventListener("webglcontextrestored", start);
start();
if (tracer) new ResizeObserver(() => { if (tracer) fit(); }).observe(element("stage"));
