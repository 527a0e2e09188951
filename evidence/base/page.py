# SPDX-License-Identifier: Apache-2.0
"""Pages from Jinja templates: the page NAME.md of a bench is made from NAME.md.in beside its module."""

from pathlib import Path

import jinja2

from .files import write_text
from .tables import series

ENVIRONMENT = jinja2.Environment(undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)
ENVIRONMENT.globals.update(MARKED="Bold values have a 95% interval that excludes 1.")
ENVIRONMENT.filters.update(series=lambda words: series(list(words)), code=lambda word: f"`{word}`", fixed=lambda value, digits=2: f"{value:.{digits}f}",
                           percent=lambda share: f"{100 * share:.0f}%")


def render(names, template, **more):
    """The text of a template in the folder of a module. `names` are the module's globals(); the template sees them and `more`."""
    folder = ENVIRONMENT.overlay(loader=jinja2.FileSystemLoader(Path(names["__file__"]).parent))
    return folder.get_template(template).render({**names, **more})


def write_page(path, names, **more):
    """Writes and prints the page at `path`."""
    text = render(names, f"{path.name}.in", **more)
    write_text(path, text)
    print(text)
