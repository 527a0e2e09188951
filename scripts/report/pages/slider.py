# SPDX-License-Identifier: Apache-2.0
"""A slider that compares two pictures and steps through sample counts, for a page that opens from disk: plain HTML and JavaScript.

The divider is a native range control below the picture (arrow keys, Home, End); it can also be dragged in the picture
with a mouse, a pen or a finger. Pictures are enlarged by whole numbers of screen pixels. The blur simulates distance:
Gaussians of 1.0 and 2.1 picture pixels on linear light with mirrored edges, as in the tables of errors. Beside it are the
error of each sampler at the count shown, and a plot of the errors in which that count is marked and others can be chosen.
"""

import base64
import html
import io
import itertools
import json
import math
import statistics

from ..base.palette import style
from ..measure.gains import REFERENCE_MARGIN
from ..measure.ratios import ratio
from . import curves, page

# With fewer seeds, intervals are too wide to be useful.
SEEDS_FOR_RATIO = 3
ERROR = "rmse_2.1"  # what is shown beside the pictures


def data_uri(image, lossless=False):
    """A Pillow image as a data URI: PNG, or JPEG without chroma subsampling at a quality that preserves noise."""
    data = io.BytesIO()
    if lossless:
        image.convert("RGB").save(data, "PNG", optimize=True)
    else:
        image.convert("RGB").save(data, "JPEG", quality=86, subsampling=0, optimize=True)
    return f"data:image/{'png' if lossless else 'jpeg'};base64," + base64.b64encode(data.getvalue()).decode()


def judged(above, below, own_error=0.0):
    """(Ratio of two lists of errors, ""), or (None, reason) if the data do not permit a ratio.

    own_error: the error of the reference.
    """
    if min(len(above), len(below)) < SEEDS_FOR_RATIO:
        return None, f"A ratio needs at least {SEEDS_FOR_RATIO} seeds."
    if min(rms(above), rms(below)) < REFERENCE_MARGIN * own_error:
        return None, f"The reference's own error, {own_error:.2g}, is too large for a ratio."
    count = min(len(above), len(below))
    return ratio(above[:count], below[:count]), ""


def rms(errors):
    return math.sqrt(statistics.mean(error * error for error in errors))


def evenly(values, digits=3):
    """Positive numbers as text, all with the same number of decimals, so that the smallest has `digits` significant digits."""
    least = min((value for value in values if value > 0), default=1.0)
    # By its text, which is rounded: 0.09996 has one zero less than its logarithm says.
    exponent = int(f"{least:.{digits - 1}e}".partition("e")[2])
    return [f"{value:.{max(0, digits - 1 - exponent)}f}" for value in values]


def verdict(left, right, errors, own_error):
    """The line below the pictures that compares two samplers."""
    shown = evenly([rms(errors[left]), rms(errors[right])])
    text = f"Error after a blur of 2.1 pixels: {left} {shown[0]}, {right} {shown[1]}. "
    found, why = judged(errors[left], errors[right], own_error)
    if found is None:
        return text + why
    count = min(len(errors[left]), len(errors[right]))
    if found.low <= 1 <= found.high:
        return text + f"No significant difference over {count} seeds."
    better = right if found.value > 1 else left
    times = sorted(max(value, 1 / value) for value in (found.low, found.value, found.high))
    return (text + f"The error of {better} is {times[1]:.2f} times smaller ({times[0]:.2f} to {times[2]:.2f} over "
            f"{count} seeds).")


STYLE = """
.compare { display: grid; gap: 1.2rem 1.6rem; grid-template-columns: minmax(0, max-content) minmax(19rem, 1fr);
  align-items: start; }
.compare .view { min-width: 0; }
.compare .controls { display: grid; grid-template-columns: 1fr 1fr; gap: .8rem; }
.compare label { display: flex; flex-direction: column; font-size: .82rem; color: var(--soft, #666); gap: .2rem; }
.compare select, .compare button { font: inherit; font-size: 1rem; min-height: 2.5rem; padding: .2rem .6rem; width: 100%;
  border: 1px solid var(--line, #ccc); border-radius: 7px; background: var(--paper, #fff); color: var(--ink, #111); }
.compare button { cursor: pointer; grid-column: 1 / -1; }
.compare select:focus-visible, .compare button:focus-visible, .compare input:focus-visible {
  outline: 2px solid var(--accent, #0050b0); outline-offset: 2px; }
.compare .stage { position: relative; overflow: hidden; touch-action: pan-y; cursor: ew-resize; user-select: none;
  background: #000; max-width: 100%; border-radius: 6px; }
.compare .stage canvas { position: absolute; left: 0; top: 0; image-rendering: pixelated; pointer-events: none; }
.compare .clip { position: absolute; inset: 0; overflow: hidden; }
.compare .divider { position: absolute; top: 0; bottom: 0; width: 2px; margin-left: -1px; background: #fff;
  box-shadow: 0 0 4px #000; pointer-events: none; }
.compare .tag { position: absolute; top: .6em; padding: .1em .6em; background: #000a; color: #fff; font-size: .9rem;
  border-radius: 1em; pointer-events: none; }
.compare .tag.left { left: .6em; }
.compare .tag.right { right: .6em; }
.compare input[type=range] { width: 100%; height: 2rem; margin: .3rem 0 0; accent-color: var(--accent, #0050b0); }
.compare output { display: block; margin-top: 1.1rem; font-variant-numeric: tabular-nums; }
@media (max-width: 860px) { .compare { grid-template-columns: minmax(0, 1fr); } .compare output { margin-top: .8rem; } }
.steps .stepping { display: grid; grid-template-columns: 2.75rem minmax(0, 1fr) 2.75rem; gap: .6rem; align-items: center; }
.compare .steps button { grid-column: auto; font: inherit; font-size: 1.25rem; line-height: 1; height: 2.75rem; padding: 0; cursor: pointer; border-radius: 7px;
  border: 1px solid var(--line); background: var(--paper); color: var(--ink); }
.steps button:disabled { opacity: .45; cursor: default; }
.steps button:focus-visible, .steps input:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
.steps .stepping input { width: 100%; height: 2.75rem; margin: 0; accent-color: var(--accent); }
.steps .count { margin: .7rem 0 .3rem; font-weight: 600; }
.found { margin-top: 1rem; }
.found .errors { width: 100%; margin: .8rem 0; }
.found .errors caption { text-align: left; font-size: .82rem; color: var(--soft); }
.found .errors :is(th, td) { text-align: left; padding: .15em .4em .15em 0; border: 0; }
.found .errors td { font-size: 1.15rem; font-weight: 600; }
.found .chart { margin: 0; padding: .4rem; cursor: crosshair; }
.found .now { stroke: #777; stroke-width: 1.2; stroke-dasharray: 3 2; }
"""

SCRIPT = """
(function () {
  "use strict";
  var root = document.getElementById("compare"), data = JSON.parse(document.getElementById("compare-data").textContent);
  var at = function (name) { return root.querySelector("[data-part=" + name + "]"); };
  var count = at("spp"), left = at("left"), right = at("right"), zoom = at("zoom"), far = at("blur");
  var stage = at("stage"), slider = at("divider"), note = at("note");
  var images = {left: at("left-image"), right: at("right-image")}, decode = [];
  for (var i = 0; i < 256; ++i) {
    var v = i / 255;
    decode.push(v <= 0.04045 ? v / 12.92 : Math.pow((v + 0.055) / 1.055, 2.4));
  }
  function encode(v) { return 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * Math.pow(v, 1 / 2.4) - 0.055); }

  function fill(select, values, wanted) {
    var old = wanted === undefined ? select.value : wanted;
    select.textContent = "";
    values.forEach(function (value) {
      var option = document.createElement("option");
      option.value = option.textContent = value;
      select.appendChild(option);
    });
    select.value = values.indexOf(old) >= 0 ? old : values[0];
  }
  function cell() { return data.counts[count.value]; }
  function names() { return Object.keys(cell().samplers).concat(data.reference ? ["reference"] : []); }
  function source(name) { return name === "reference" ? data.reference : cell().samplers[name].picture; }
  // One pass of the Gaussian over lines of `size` values, `step` apart; the next line begins `skip` further.
  function pass(from, sigma, size, step, lines, skip) {
    var to = new Float32Array(from.length), radius = Math.floor(4 * sigma + 0.5), weights = [], sum = 0, k, j, i, c;
    for (k = -radius; k <= radius; ++k) { weights.push(Math.exp(-0.5 * k * k / (sigma * sigma))); sum += weights[k + radius]; }
    for (j = 0; j < lines; ++j)
      for (i = 0; i < size; ++i)
        for (k = -radius; k <= radius; ++k) {
          var at = ((i + k) % (2 * size) + 2 * size) % (2 * size);
          if (at >= size) at = 2 * size - 1 - at;
          for (c = 0; c < 3; ++c)
            to[j * skip + i * step + c] += weights[k + radius] / sum * from[j * skip + at * step + c];
        }
    return to;
  }
  function paint(canvas, uri, sigma) {
    var picture = new Image();
    canvas.wanted = picture;
    picture.onload = function () {
      if (canvas.wanted !== picture) return;
      var width = picture.naturalWidth, height = picture.naturalHeight, context = canvas.getContext("2d");
      canvas.width = width;
      canvas.height = height;
      context.drawImage(picture, 0, 0);
      if (!sigma) return;
      var pixels = context.getImageData(0, 0, width, height), light = new Float32Array(3 * width * height), i, c;
      for (i = 0; i < width * height; ++i)
        for (c = 0; c < 3; ++c) light[3 * i + c] = decode[pixels.data[4 * i + c]];
      light = pass(light, sigma, width, 3, height, 3 * width);
      light = pass(light, sigma, height, 3 * width, width, 3);
      for (i = 0; i < width * height; ++i)
        for (c = 0; c < 3; ++c) pixels.data[4 * i + c] = encode(light[3 * i + c]);
      context.putImageData(pixels, 0, 0);
    };
    picture.src = uri;
  }
  function say() {
    var notes = cell().notes, one = left.value, other = right.value;
    note.textContent = notes[one + "|" + other] || notes[other + "|" + one] || "";
  }
  function place() {
    var width = images.left.clientWidth, x = width * slider.value / 1000;
    at("clip").style.clipPath = "inset(0 0 0 " + x + "px)";
    at("line").style.left = x + "px";
    slider.setAttribute("aria-valuetext", Math.round(slider.value / 10) + " percent " + left.value + ", the rest " +
                        right.value);
  }
  function show() {
    var size = data.size, factor = Number(zoom.value);
    if (!factor) {
      // Beside the controls where there is room; whole numbers of the screen's own pixels, which may be small.
      var room = root.clientWidth - (root.clientWidth > 800 ? 370 : 40), dots = window.devicePixelRatio || 1;
      factor = Math.max(1, Math.floor(dots * Math.min(room / size[0], 680 / size[1]))) / dots;
    }
    ["left", "right"].forEach(function (side) {
      var name = side === "left" ? left.value : right.value, image = images[side];
      paint(image, source(name), Number(far.value));
      image.setAttribute("aria-label", data.scene + ", " + name + ", " + count.value +
                         (count.value === "1" ? " sample" : " samples") + " per pixel");
      image.style.width = size[0] * factor + "px";
      image.style.height = size[1] * factor + "px";
      at(side + "-tag").textContent = name;
    });
    stage.style.width = slider.style.width = size[0] * factor + "px";
    stage.style.height = size[1] * factor + "px";
    slider.style.maxWidth = "100%";
    place();
    say();
  }
  function countChanged() { fill(left, names()); fill(right, names()); show(); }
  function drag(event) {
    var box = stage.getBoundingClientRect();
    slider.value = Math.round(1000 * Math.min(1, Math.max(0, (event.clientX - box.left) / images.left.clientWidth)));
    place();
  }

  far.value = data.start.blur;
  count.parentNode.style.gridColumn = "1 / -1";
  fill(count, Object.keys(data.counts), data.start.spp);
  fill(left, names(), data.start.left);
  fill(right, names(), data.start.right);
  count.addEventListener("change", countChanged);
  [left, right, zoom, far].forEach(function (control) { control.addEventListener("change", show); });
  slider.addEventListener("input", place);
  at("swap").addEventListener("click", function () {
    var old = left.value;
    left.value = right.value;
    right.value = old;
    show();
  });
  stage.addEventListener("pointerdown", function (event) { stage.setPointerCapture(event.pointerId); drag(event); });
  stage.addEventListener("pointermove", function (event) { if (event.buttons) drag(event); });
  window.addEventListener("resize", show);
  show();
})();
document.addEventListener("DOMContentLoaded", function () {
  "use strict";
  var root = document.getElementById("steps"), data = JSON.parse(document.getElementById("steps-data").textContent);
  var select = document.querySelector("#compare [data-part=spp]"), slider = root.querySelector("input");
  var less = root.querySelector("[data-step='-1']"), more = root.querySelector("[data-step='1']");
  var plot = document.querySelector(".found .chart svg"), line = document.querySelector(".found .now");
  select.parentNode.style.display = "none";
  function to(index, said) {
    var i = Math.max(0, Math.min(data.counts.length - 1, index)), count = data.counts[i];
    slider.value = i;
    less.disabled = i === 0;
    more.disabled = i === data.counts.length - 1;
    root.querySelector(".count").textContent = data.names[i];
    slider.setAttribute("aria-valuetext", data.names[i]);
    document.querySelectorAll(".found [data-error]").forEach(function (cell) { cell.textContent = data.errors[cell.dataset.error][i]; });
    if (line) {
      line.setAttribute("x1", data.places[i]);
      line.setAttribute("x2", data.places[i]);
    }
    if (said || select.value === String(count)) return;
    select.value = String(count);
    select.dispatchEvent(new Event("change"));
  }
  function nearest(event) {
    var box = plot.getBoundingClientRect(), x = (event.clientX - box.left) / box.width * plot.viewBox.baseVal.width, best = 0;
    data.places.forEach(function (place, i) { if (Math.abs(place - x) < Math.abs(data.places[best] - x)) best = i; });
    to(best);
  }
  slider.addEventListener("input", function () { to(Number(slider.value)); });
  less.addEventListener("click", function () { to(Number(slider.value) - 1); });
  more.addEventListener("click", function () { to(Number(slider.value) + 1); });
  if (plot) {
    plot.addEventListener("pointerdown", nearest);
    plot.addEventListener("pointermove", function (event) { if (event.buttons) nearest(event); });
  }
  to(data.counts.indexOf(Number(select.value)), true);
});
"""


def plot(rows, samplers):
    """(SVG of the blurred error against samples with a line to mark a count, {count: its place along the picture})."""
    figure = curves.error_curve(rows, samplers, "spp", ERROR, "Error after a blur of 2.1 pixels")
    axis = figure.axes[0]
    wide, high = (72 * inches for inches in figure.get_size_inches())
    box = axis.get_position()
    places = {row["spp"]: float(72 * axis.transData.transform((row["spp"], 1))[0] / figure.dpi) for row in rows}
    text = page.svg(figure)
    line = f'<line class="now" y1="{high * (1 - box.y1):.1f}" y2="{high * (1 - box.y0):.1f}"/></svg>'
    assert f'viewBox="0 0 {wide:g} {high:g}"' in text  # the places are in these units
    return line.join(text.rsplit("</svg>", 1)), places


def stepper(counts, samplers, rows):
    """HTML under the pictures and under the controls; without rows, errors are still unknown."""
    data = {"counts": list(counts), "names": [page.samples(count) for count in counts], "errors": {}, "places": []}
    shown = ""
    if rows:
        found = {(row["sampler"], row["spp"]): row[ERROR] for row in rows}
        by_count = [evenly([found[sampler, count] for sampler in samplers]) for count in counts]
        data["errors"] = {sampler: [texts[i] for texts in by_count] for i, sampler in enumerate(samplers)}
        drawn, places = plot(rows, samplers)
        data["places"] = [round(places[count], 2) for count in counts]
        heads = "".join(f'<th scope=col><span class=dot style="background:{style(s, samplers)["color"]}"></span>{html.escape(s)}</th>'
                        for s in samplers)
        cells = "".join(f'<td data-error="{html.escape(s)}"></td>' for s in samplers)
        shown = ("<div class=found><table class=errors><caption>Error after a blur of 2.1 pixels, over all seeds</caption>"
                 f"<thead><tr>{heads}</tr></thead><tbody><tr>{cells}</tr></tbody></table>{page.chart(drawn)}</div>")
    stepping = ("<div class=steps id=steps><p class=count aria-live=polite></p><div class=stepping>"
                '<button type=button data-step="-1" aria-label="one sample less">&#8722;</button>'
                f'<input type=range min=0 max={len(counts) - 1} step=1 aria-label="samples per pixel">'
                '<button type=button data-step="1" aria-label="one sample more">+</button></div></div>' + as_json("steps-data", data))
    return stepping, shown


def as_json(name, data):
    # "</" would end the script element.
    text = json.dumps(data, separators=(",", ":")).replace("</", "<\\/")
    return f'<script type="application/json" id={name}>{text}</script>'


def widget(scene, reference, pictures, samplers, rows=(), own_error=0.0, spp=4, blur="0"):
    """The controls, the pictures and the script.

    scene: its name. reference: an 8-bit image with its own error, or None while there is none; pictures: {(sampler, spp): 8-bit
    image}; rows: dicts with sampler, spp, ERROR and "each": {ERROR: [of each seed]}, none while errors are unknown. spp, blur:
    the initial selection, with the first sampler on the left and the last on the right.
    """
    counts = list(dict.fromkeys(count for _, count in pictures))
    errors = {(row["sampler"], row["spp"]): row["each"][ERROR] for row in rows}
    uris = {key: data_uri(image, len(pictures) < 16) for key, image in pictures.items()}
    data = {"start": {"left": samplers[0], "right": samplers[-1], "spp": str(spp), "blur": blur}, "scene": scene,
            "size": next(iter(pictures.values())).size, "reference": data_uri(reference, True) if reference else "",
            "counts": {str(count): {"samplers": {s: {"picture": uris[s, count]} for s in samplers},
                                    "notes": notes({s: errors[s, count] for s in samplers}, own_error) if rows else {}} for count in counts}}
    below, beside = stepper(counts, samplers, rows)

    def select(part, label, options=()):
        inside = "".join(f'<option value="{value}">{html.escape(text)}</option>' for value, text in options)
        return f"<label>{label}<select data-part={part}>{inside}</select></label>"

    zooms = [("0", "to fit")] + [(str(n), f"{n} times") for n in (1, 2, 3, 4, 6, 8)]
    blurs = [("0", "none"), ("1", "1.0 px: close"), ("2.1", "2.1 px: far")]
    return (f'<style>{STYLE}</style><div class="compare card" id=compare><div class=view>'
            '<div class=stage data-part=stage><canvas data-part=left-image role=img></canvas><div class=clip data-part=clip>'
            '<canvas data-part=right-image role=img></canvas></div><div class=divider data-part=line></div>'
            '<span class="tag left" data-part=left-tag></span><span class="tag right" data-part=right-tag></span></div>'
            '<input type=range data-part=divider min=0 max=1000 value=500 '
            f'aria-label="divider between the left and the right picture">{below}</div>'
            f'<div><div class=controls>{select("spp", "Samples per pixel")}'
            f'{select("left", "Left")}{select("right", "Right")}'
            f'{select("blur", "Blur", blurs)}{select("zoom", "Enlarged", zooms)}'
            '<button type=button data-part=swap title="exchange left and right">&#8644; swap</button></div>'
            f'<output data-part=note aria-live=polite></output>{beside}</div></div>{as_json("compare-data", data)}<script>{SCRIPT}</script>')


def notes(errors, own_error):
    """The line for each pair of names."""
    said = {f"{one}|{other}": verdict(one, other, errors, own_error) for one, other in itertools.combinations(errors, 2)}
    for name in errors:
        said[f"{name}|reference"] = f"Error of {name} after a blur of 2.1 pixels: {evenly([rms(errors[name])])[0]}."
        said[f"{name}|{name}"] = "The same picture on both sides."
    return {**said, "reference|reference": "The same picture on both sides."}
