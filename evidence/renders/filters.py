# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers with a box filter and with a Gaussian pixel filter: `scripts/bench filters` writes evidence/results/filters.*"""

import dataclasses

from ..base.files import write_rows
from ..base.page import write_page
from ..measure import compare
from ..samplers import variants
from . import renders, views

COUNTS = (1, 2, 4, 8, 16)
FILTERS = {"box": (), "gaussian": ("--filter", "gaussian")}
MEASURED = {"displayed_2.1": "after a 2.1-pixel blur", "displayed": "without a blur"}


def table(reports, measure, counts):
    others = next(iter(reports.values())).others
    return compare.table("error over padded Sobol'", counts, {
        f"{renders.NAMES.get(label, label)}, {name}": report.over(label, measure) for label in others for name, report in reports.items()})


def run(arguments):
    options = views.parse_options("filters", __doc__, arguments, COUNTS, crop=views.QUICK_CROP, spp=max(COUNTS), reference_spp=256,
                                  scenes=views.BUILT_IN, samplers=("white", "sobol", "zorder", "mask", "blue"))
    chosen, reports = options.chosen, {}
    for name, more in FILTERS.items():
        options.chosen = tuple(dataclasses.replace(view, camera=(*view.camera, *more)) for view in chosen)
        cells, references = renders.measured(options)
        reports[name] = renders.Report(options, cells, references)
    rows = [{"filter": name, **row} for name, report in reports.items() for row in report.compared.rows(options.counts, MEASURED)]
    write_rows(options.out / "filters.csv", ("filter", *compare.FIELDS), rows)
    write_page(options.out / "filters.md", globals(), reports=reports, compared=reports["box"].compared, options=options, variants=variants)
