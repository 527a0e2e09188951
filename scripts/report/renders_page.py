# SPDX-License-Identifier: Apache-2.0
"""The HTML page of `scripts/bench renders`: a slider that compares two pictures, plots and tables."""

import math
import statistics

from . import comparison, curves, page
from .gains import HEADLINE_MEASURES
from .image_error import measure_name
from .judge import SHOWN_COUNTS
from .renders_plots import shown


def slider(report, counts):
    scenes = {}
    for scene in report.scenes:
        view = report.first_view(scene)
        cells = {spp: {label: (comparison.data_uri(shown(report, scene, label, spp)),
                               report.cells.get(view, label, spp, "rmse_2.1"))
                       for label in report.labels if (view, label, spp) in report.cells.pictures} for spp in counts}
        scenes[scene] = {"size": view.size, "reference": comparison.data_uri(shown(report, scene, None, None)),
                         "own_error": report.references[view].own["rmse_2.1"], "counts": cells}
    return comparison.widget(scenes, spp=counts[0])


def headlines(report, counts):
    """Blue's gains as displayed, where there are enough seeds."""
    found = []
    for than in report.gains.thans():
        for spp in counts:
            gain = report.gains.gain("blue", spp, "displayed_2.1", than) if "blue" in report.labels else None
            if gain and report.options.seeds[spp] >= comparison.SEEDS_FOR_RATIO:
                interval, at = f"({gain.low:.2f} to {gain.high:.2f})", page.samples(spp)
                found.append(("even", f"with {than} at {at} {interval}") if gain.low <= 1 <= gain.high else
                             (f"{gain.value:.2f} \u00d7", f"less error than {than} at {at} {interval}"))
    return found


def overall(report, measure):
    """Gains over white noise, over all scenes and crops, with the interval of blue."""
    found = {label: {spp: (gain.value, gain.low, gain.high) for spp in report.counts
                     if (gain := report.gains.gain(label, spp, measure, "white"))} for label in report.labels}
    return curves.gain_lines(found, report.labels, measure_name(measure), "white", banded=("blue",))


def of_scene(report, scene, measure):
    found = {}
    for label in report.labels:
        for spp in report.counts:
            values = list(report.spread(scene, label, spp, measure, "white").values())
            if values:
                mean = math.exp(statistics.mean(map(math.log, values)))
                found.setdefault(label, {})[spp] = (mean, mean, mean)
    return curves.gain_lines(found, report.labels, scene, "white")


def gain_rows(report, measure):
    rows = []
    for spp in report.counts:
        found = [report.gains.gain("blue", spp, measure, than) for than in report.gains.thans()]
        if any(found):
            rows.append([spp, *(gain.text() if gain else "" for gain in found)])
    return rows


def html_page(report):
    counts = [spp for spp in SHOWN_COUNTS if spp in report.counts]
    facts, first = headlines(report, counts), HEADLINE_MEASURES[0]
    side = [page.paragraph(report.short().replace("`", "")), slider(report, counts)]
    if facts:
        side += [page.facts(facts, len(counts)), page.paragraph(
            f"The sampler blue, {measure_name('displayed_2.1')}: geometric means over {len(report.scenes)} scenes and "
            f"{len(report.views)} crops, with 95 % intervals.")]
    plots = [page.paragraph("Error reduction over white noise, over all scenes and crops; the band is the interval of "
                            "blue:"),
             page.grid(page.chart(overall(report, measure)) for measure in HEADLINE_MEASURES),
             page.paragraph(f"Each scene, {measure_name(first)}, mean over its crops:"),
             page.grid(page.chart(of_scene(report, scene, first)) for scene in report.scenes)]
    figures = []
    for measure in HEADLINE_MEASURES if "blue" in report.labels else ():
        figures += [page.paragraph(f"Error reduction of blue over each of these, {measure_name(measure)}:"),
                    page.table(("samples per pixel", *report.gains.thans()), gain_rows(report, measure))]
    lead = ("The built-in scenes of libbn's example path tracer. Drag the divider, or move it with the arrow keys; the blur "
            "shows what remains visible from a distance. The pictures show each scene's first crop, the figures cover all.")
    return page.page("Samplers in rendered scenes", [("Side by side", side), ("Plots", plots), ("Tables", figures)], lead,
                     f"Measured by {report.options.command}. All figures are in docs/report/renders.md and in renders.csv "
                     "beside this page.")
