# SPDX-License-Identifier: Apache-2.0
"""Steps through sample counts on a page with comparison.widget: a slider with two buttons, the error of each sampler at the
count shown, and a plot of the errors at all counts in which that count is marked and others can be chosen."""

import html
import json

from ..base.palette import style
from . import comparison, curves, page

STYLE = """
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
    figure = curves.error_curve(rows, samplers, "spp", "blurred", "Error after a blur of 2.1 pixels")
    axis = figure.axes[0]
    wide, high = (72 * inches for inches in figure.get_size_inches())
    box = axis.get_position()
    places = {row["spp"]: float(72 * axis.transData.transform((row["spp"], 1))[0] / figure.dpi) for row in rows}
    text = page.svg(figure, fit=False)
    line = f'<line class="now" y1="{high * (1 - box.y1):.1f}" y2="{high * (1 - box.y0):.1f}"/></svg>'
    assert f'viewBox="0 0 {wide:g} {high:g}"' in text  # the places are in these units
    return line.join(text.rsplit("</svg>", 1)), places


def stepper(counts, samplers, rows=()):
    """HTML under the pictures and under the controls of comparison.widget, which starts at one of the counts.

    rows: dicts with sampler, spp, blurred (the error) and each, as curves.error_curve takes them; none while errors are unknown.
    """
    data = {"counts": list(counts), "names": [page.samples(count) for count in counts], "errors": {}, "places": []}
    shown = ""
    if rows:
        found = {(row["sampler"], row["spp"]): row["blurred"] for row in rows}
        by_count = [comparison.evenly([found[sampler, count] for sampler in samplers]) for count in counts]
        data["errors"] = {sampler: [texts[i] for texts in by_count] for i, sampler in enumerate(samplers)}
        drawn, places = plot(rows, samplers)
        data["places"] = [round(places[count], 2) for count in counts]
        heads = "".join(f'<th scope=col><span class=dot style="background:{style(s, samplers)["color"]}"></span>{html.escape(s)}</th>'
                        for s in samplers)
        cells = "".join(f'<td data-error="{html.escape(s)}"></td>' for s in samplers)
        shown = ("<div class=found><table class=errors><caption>Error after a blur of 2.1 pixels, over all seeds</caption>"
                 f"<thead><tr>{heads}</tr></thead><tbody><tr>{cells}</tr></tbody></table>{page.chart(drawn)}</div>")
    text = json.dumps(data, separators=(",", ":")).replace("</", "<\\/")
    stepping = (f"<style>{STYLE}</style><div class=steps id=steps><p class=count aria-live=polite></p><div class=stepping>"
            '<button type=button data-step="-1" aria-label="one sample less">&#8722;</button>'
            f'<input type=range min=0 max={len(counts) - 1} step=1 aria-label="samples per pixel">'
            '<button type=button data-step="1" aria-label="one sample more">+</button></div></div>'
            f'<script type="application/json" id=steps-data>{text}</script><script>{SCRIPT}</script>')
    return stepping, shown
