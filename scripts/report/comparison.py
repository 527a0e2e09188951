# SPDX-License-Identifier: Apache-2.0
"""Two pictures under one slider, for a page that opens from disk: plain HTML and a page of JavaScript.

The divider is a native range control under the picture (arrow keys, Home, End), and the picture itself can be
dragged with a mouse, a pen or a finger. Pixels are shown as whole numbers of screen pixels; the blur stands for
distance: Gaussians of 1.0 and 2.1 picture pixels on linear light, edges mirrored, as the tables' errors are blurred.
"""

import base64
import html
import io
import json


def data_uri(image, lossless=False):
    """A Pillow image: as PNG, or as JPEG with all its colour and at a quality at which noise stays noise."""
    data = io.BytesIO()
    if lossless:
        image.convert("RGB").save(data, "PNG", optimize=True)
    else:
        image.convert("RGB").save(data, "JPEG", quality=86, subsampling=0, optimize=True)
    return f"data:image/{'png' if lossless else 'jpeg'};base64," + base64.b64encode(data.getvalue()).decode()


STYLE = """
.compare { margin: 1.5em 0; }
.compare .controls { display: flex; flex-wrap: wrap; gap: .6em 1.4em; align-items: end; margin-bottom: .8em; }
.compare label { display: flex; flex-direction: column; font-size: .85em; gap: .15em; }
.compare select, .compare button { font: inherit; padding: .25em .5em; min-height: 2.4em; }
.compare .stage { position: relative; overflow: hidden; touch-action: pan-y; cursor: ew-resize; user-select: none;
  background: #000; max-width: 100%; }
.compare .stage canvas { position: absolute; left: 0; top: 0; image-rendering: pixelated; pointer-events: none; }
.compare .clip { position: absolute; inset: 0; overflow: hidden; }
.compare .divider { position: absolute; top: 0; bottom: 0; width: 2px; margin-left: -1px; background: #fff;
  box-shadow: 0 0 3px #000; pointer-events: none; }
.compare .tag { position: absolute; bottom: .5em; padding: .1em .5em; background: #000b; color: #fff; font-size: .9em;
  border-radius: .3em; pointer-events: none; }
.compare .tag.left { left: .5em; }
.compare .tag.right { right: .5em; }
.compare input[type=range] { width: 100%; height: 2em; margin: .3em 0; }
.compare output { display: block; min-height: 3em; font-variant-numeric: tabular-nums; }
"""

SCRIPT = """
(function () {
  "use strict";
  var root = document.getElementById("compare"), data = JSON.parse(document.getElementById("compare-data").textContent);
  var at = function (name) { return root.querySelector("[data-part=" + name + "]"); };
  var scene = at("scene"), count = at("spp"), left = at("left"), right = at("right"), zoom = at("zoom"), far = at("blur");
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
  function cell() { return data.scenes[scene.value].counts[count.value]; }
  function names() { return Object.keys(cell().samplers).concat(["reference"]); }
  function source(name) {
    return name === "reference" ? data.scenes[scene.value].reference : cell().samplers[name].picture;
  }
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
    var a = cell().samplers[left.value], b = cell().samplers[right.value];
    function part(name, entry) { return name + " " + Number(entry.error).toPrecision(3); }
    if (!a && !b) { note.textContent = "The reference, beside itself."; return; }
    var text = "Error after a blur of 2.1 pixels: " + (a ? part(left.value, a) : part(right.value, b));
    if (a && b) {
      text += ", " + part(right.value, b);
      var less = a.error < b.error ? left.value : right.value, more = less === left.value ? right.value : left.value;
      if (less !== more)
        text += " \\u2014 " + less + " has " + (Math.max(a.error, b.error) / Math.min(a.error, b.error)).toFixed(2) +
                " times less than " + more;
    }
    note.textContent = text + ".";
  }
  function place() {
    var width = images.left.clientWidth, x = width * slider.value / 1000;
    at("clip").style.clipPath = "inset(0 0 0 " + x + "px)";
    at("line").style.left = x + "px";
    slider.setAttribute("aria-valuetext", Math.round(slider.value / 10) + " percent " + left.value + ", the rest " +
                        right.value);
  }
  function show() {
    var size = data.scenes[scene.value].size, factor = Number(zoom.value);
    if (!factor) factor = Math.max(1, Math.floor(Math.min(root.clientWidth / size[0], 640 / size[1])));
    ["left", "right"].forEach(function (side) {
      var name = side === "left" ? left.value : right.value, image = images[side];
      paint(image, source(name), Number(far.value));
      image.setAttribute("aria-label", scene.value + ", " + name + ", " + count.value + " samples per pixel");
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
  function sceneChanged() { fill(count, Object.keys(data.scenes[scene.value].counts)); countChanged(); }
  function countChanged() { fill(left, names()); fill(right, names()); show(); }
  function drag(event) {
    var box = stage.getBoundingClientRect();
    slider.value = Math.round(1000 * Math.min(1, Math.max(0, (event.clientX - box.left) / images.left.clientWidth)));
    place();
  }

  fill(scene, Object.keys(data.scenes));
  fill(count, Object.keys(data.scenes[scene.value].counts), data.start.spp);
  fill(left, names(), data.start.left);
  fill(right, names(), data.start.right);
  scene.addEventListener("change", sceneChanged);
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
"""


def widget(scenes, left="white", right="blue", spp=4):
    """The controls, the pictures and the script.

    scenes: {name: {"size": (width, height), "reference": URI, "counts": {spp: {sampler: (URI, error)}}}}, where
    error is the RMSE after a blur of 2.1 pixels. left, right, spp: what is shown at first, if it is there.
    """
    data = {"start": {"left": left, "right": right, "spp": str(spp)}, "scenes": {
        name: {"size": list(scene["size"]), "reference": scene["reference"], "counts": {
            str(count): {"samplers": {sampler: {"picture": uri, "error": error}
                                      for sampler, (uri, error) in samplers.items()}}
            for count, samplers in scene["counts"].items()}}
        for name, scene in scenes.items()}}

    def select(part, label, options=()):
        inside = "".join(f'<option value="{value}">{html.escape(text)}</option>' for value, text in options)
        return f"<label>{label}<select data-part={part}>{inside}</select></label>"

    zooms = [("0", "fitting")] + [(str(n), f"{n} times") for n in (1, 2, 3, 4, 6, 8)]
    blurs = [("0", "none: each pixel"), ("1", "sigma 1.0: near"), ("2.1", "sigma 2.1: far")]
    # "</" would end the script element wherever it stood.
    text = json.dumps(data, separators=(",", ":")).replace("</", "<\\/")
    return (f'<style>{STYLE}</style><div class=compare id=compare><div class=controls>'
            f'{select("scene", "scene")}{select("spp", "samples per pixel")}{select("left", "left")}'
            f'<button type=button data-part=swap title="exchange left and right">&#8644; swap</button>'
            f'{select("right", "right")}{select("zoom", "enlarged", zooms)}{select("blur", "blur", blurs)}</div>'
            '<div class=stage data-part=stage><canvas data-part=left-image role=img></canvas><div class=clip data-part=clip>'
            '<canvas data-part=right-image role=img></canvas></div><div class=divider data-part=line></div>'
            '<span class="tag left" data-part=left-tag></span><span class="tag right" data-part=right-tag></span></div>'
            '<input type=range data-part=divider min=0 max=1000 value=500 '
            'aria-label="divider between the left and the right picture">'
            '<output data-part=note aria-live=polite></output></div>'
            f'<script type="application/json" id=compare-data>{text}</script><script>{SCRIPT}</script>')
