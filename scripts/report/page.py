# SPDX-License-Identifier: Apache-2.0
"""A report page in one file: pictures are inside it, so it opens from disk, can be mailed, and asks no network."""

import base64
import html
import io

STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 1180px; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .15em .8em; text-align: right; border-bottom: 1px solid #8884; }
th:first-child, td:first-child { text-align: left; }
tr.best td { font-weight: 600; }
.pixels { image-rendering: pixelated; max-width: none; }
.wide { overflow-x: auto; }
figure { margin: 1.5em 0; }
figcaption { max-width: 60em; opacity: .8; }
code { background: #8882; padding: 0 .25em; }
"""


def paragraph(text):
    return f"<p>{html.escape(text)}</p>"


def table(header, rows, highlighted=()):
    """Rows of texts; highlighted: the indices of rows to set in bold."""
    def line(cells, tag):
        return "".join(f"<{tag}>{html.escape(str(cell))}</{tag}>" for cell in cells)

    body = "".join(f"<tr{' class=best' if i in highlighted else ''}>{line(row, 'td')}</tr>\n"
                   for i, row in enumerate(rows))
    return f"<div class=wide><table><thead><tr>{line(header, 'th')}</tr></thead>\n<tbody>{body}</tbody></table></div>"


def picture(image, caption):
    """A figure of a Pillow image, one image pixel per page pixel."""
    data = io.BytesIO()
    image.save(data, "PNG", optimize=True)
    source = base64.b64encode(data.getvalue()).decode()
    caption = html.escape(caption)
    return (f'<figure><div class=wide><img class=pixels width={image.width} height={image.height} '
            f'alt="{caption}" src="data:image/png;base64,{source}"></div><figcaption>{caption}</figcaption></figure>')


def svg(figure, fit=True):
    """A Matplotlib figure as the text of an SVG file; fit: cut to what is drawn, which takes as long as drawing."""
    data = io.StringIO()
    figure.savefig(data, format="svg", bbox_inches="tight" if fit else None)
    return data.getvalue()


def chart(figure, caption):
    """A figure of a Matplotlib figure or of the text of an SVG file."""
    text = figure if isinstance(figure, str) else svg(figure)
    return f"<figure><div class=wide>{text[text.index('<svg'):]}</div><figcaption>{html.escape(caption)}</figcaption></figure>"


def page(title, sections):
    """The whole page; sections are (heading, list of parts made by the functions above)."""
    body = "\n".join(f"<h2>{html.escape(heading)}</h2>\n" + "\n".join(parts) for heading, parts in sections)
    return (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style></head>\n'
            f"<body><h1>{html.escape(title)}</h1>\n{body}\n</body></html>\n")
