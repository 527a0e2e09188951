// SPDX-License-Identifier: Apache-2.0
// The errors of the samplers after 1, 2, 3 ... samples: measures them one at a time and shows them as numbers and in a plot.
"use strict";

const STEPS = 16;
const BLUR_OF_ERRORS = 2.1; // in pixels, as in libbn's tables

/* Formats positive numbers with the same number of decimals, so that the smallest has three significant digits. */
function evenly(values) {
  const least = Math.min(...values.filter(value => value > 0), 1);
  const exponent = Number(least.toExponential(2).split("e")[1]);
  return values.map(value => value.toFixed(Math.max(0, 2 - exponent)));
}

/* Calls choose(count) when the user picks a sample count in the plot. */
function makeErrors(names, choose) {
  const types = Object.keys(names), plot = document.getElementById("plot"), list = document.getElementById("values");
  const cells = {};
  for (const type of types) {
    const both = document.createElement("div"), name = document.createElement("dt"), value = document.createElement("dd");
    both.className = type;
    name.textContent = names[type];
    cells[type] = value;
    both.append(name, value);
    list.append(both);
  }
  const margin = {left: 46, right: 12, top: 8, bottom: 34}, height = 200;
  let steps = {}, running = [], shown = 0, drawn = "";

  const part = (name, attributes, text = "") => {
    const made = document.createElementNS(plot.namespaceURI, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.textContent = text;
    return made;
  };
  const width = () => plot.clientWidth || 200;
  const across = count => margin.left + Math.log2(count) / Math.log2(STEPS) * (width() - margin.left - margin.right);

  const errors = {
    get values() { return steps; },
    get done() { return running.length === 0; },

    /* Discards the errors, so that they are remeasured step by step. */
    restart(tracer) {
      for (const {run} of running) run.return();
      steps = Object.fromEntries(types.map(type => [type, []]));
      running = tracer ? types.map(type => ({type, run: tracer.errors(type, BLUR_OF_ERRORS)})) : [];
      drawn = "";
      errors.show(shown);
    },

    /* Measures one error for the sampler with the fewest errors. */
    step() {
      if (errors.done) return;
      const next = running.shift();
      steps[next.type].push(next.run.next().value);
      if (steps[next.type].length < STEPS) running.push(next);
      else next.run.return();
      errors.show(shown);
    },

    show(count) {
      const known = types.map(type => (steps[type] || []).length).join();
      if (Math.min(count, STEPS) === shown && known === drawn) return;
      shown = Math.min(count, STEPS);
      drawn = known;
      const values = types.map(type => steps[type] && steps[type][shown - 1]);
      const texts = values.every(value => value !== undefined) ? evenly(values) : values.map(() => "\u2026");
      types.forEach((type, i) => { cells[type].textContent = texts[i]; });
      errors.draw();
    },

    draw() {
      const all = types.flatMap(type => steps[type] || []).filter(value => value > 0);
      plot.setAttribute("height", height);
      plot.setAttribute("viewBox", `0 0 ${width()} ${height}`);
      plot.replaceChildren();
      const bottom = height - margin.bottom, end = width() - margin.right;
      for (let count = 1; count <= STEPS; ++count) {
        const x = across(count);
        plot.append(part("line", {class: count === shown ? "now" : "grid", x1: x, x2: x, y1: margin.top, y2: bottom}));
        if ([1, 2, 3, 4, 6, 8, 12, 16].includes(count)) plot.append(part("text", {x, y: bottom + 14, "text-anchor": "middle"}, count));
      }
      plot.append(part("text", {x: (margin.left + end) / 2, y: height - 4, "text-anchor": "middle"}, "samples per pixel"));
      if (!all.length) return;
      const most = Math.max(...all) * 1.08, least = Math.min(...all, most / 4) / 1.08;
      const down = value => margin.top + Math.log(most / value) / Math.log(most / least) * (bottom - margin.top);
      for (const tick of [0.001, 0.002, 0.003, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.3]) {
        if (tick < least || tick > most) continue;
        plot.append(part("line", {class: "grid", x1: margin.left, x2: end, y1: down(tick), y2: down(tick)}));
        plot.append(part("text", {x: margin.left - 6, y: down(tick) + 4, "text-anchor": "end"}, tick));
      }
      for (const type of types) {
        const points = steps[type].map((value, i) => [across(i + 1), down(value)]);
        plot.append(part("polyline", {class: type, points: points.map(point => point.join(",")).join(" ")}));
        for (const [i, [x, y]] of points.entries()) plot.append(part("circle", {class: type, cx: x, cy: y, r: i + 1 === shown ? 4.5 : 2.2}));
      }
    },
  };

  const pick = event => {
    const x = event.clientX - plot.getBoundingClientRect().left;
    const counts = Array.from({length: STEPS}, (_, i) => i + 1);
    choose(counts.reduce((best, count) => Math.abs(across(count) - x) < Math.abs(across(best) - x) ? count : best));
  };
  plot.addEventListener("pointerdown", event => { plot.setPointerCapture(event.pointerId); pick(event); });
  plot.addEventListener("pointermove", event => { if (plot.hasPointerCapture(event.pointerId)) pick(event); });
  return errors;
}
