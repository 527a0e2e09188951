# SPDX-License-Identifier: Apache-2.0
"""The page of `scripts/bench renders`: two pictures under a slider, and its aims."""

import math
import statistics

from . import comparison, page
from .judge import SHOWN_COUNTS
from .renders_plots import shown


def html_page(report):
    counts = [spp for spp in SHOWN_COUNTS if spp in report.counts]
    scenes = {}
    for scene in report.scenes:
        view = report.first_view(scene)
        cells = {spp: {label: (comparison.data_uri(shown(report, scene, label, spp)),
                               math.sqrt(statistics.mean(
                                   e * e for e in report.cells.get(view, label, spp, "rmse_2.1"))))
                       for label in report.labels if (view, label, spp) in report.cells.pictures} for spp in counts}
        scenes[scene] = {"size": view.size, "reference": comparison.data_uri(shown(report, scene, None, None)),
                         "counts": cells}
    parts = [page.paragraph("The first view of each built-in scene of libbn's example path tracer. Drag the divider, or move it with the arrow keys. A blur stands for distance: what blue noise "
                            "leaves there is what an eye far off still sees."), comparison.widget(scenes)]
    aims = report.aims()
    measured = [page.table(("what", "aim", "measured", ""), aims, [i for i, row in enumerate(aims) if row[3] != "met"]),
                page.paragraph(f"Measured by {report.options.command}; all figures are in docs/report/renders.md and in renders.csv beside "
                               "this page. Bold: missed.")]
    return page.page("Samplers in rendered scenes", [("Two samplers side by side", parts), ("Aims", measured)])
