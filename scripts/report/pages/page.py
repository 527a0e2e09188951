# SPDX-License-Identifier: Apache-2.0
"""A self-contained HTML report: pictures are embedded, so it opens from disk, can be mailed and needs no network.

The functions below return HTML. A page goes from pictures to plots to tables: the result is visible first, and the
figures follow.
"""

import base64
import html
import io

STYLE = """
:root { color-scheme: light dark; --paper: #f6f6f3; --card: #fff; --ink: #1b1c1e; --soft: #62656b; --line: #dcdcd6;
  --accent: #0050b0; --tint: #e9f0f9; }
@media (prefers-color-scheme: dark) { :root { --paper: #131417; --card: #1d1f23; --ink: #e8e8e6; --soft: #a0a3a9;
  --line: #34373d; --accent: #7db4f5; --tint: #20304a; } .chart svg { filter: invert(.88) hue-rotate(180deg); } }
* { box-sizing: border-box; }
body { font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; margin: 0; background: var(--paper);
  color: var(--ink); }
header, main { max-width: 1240px; margin: 0 auto; padding: 0 clamp(.9rem, 3vw, 2rem); }
header { padding-top: clamp(1.4rem, 4vw, 3rem); }
h1 { font-size: clamp(1.5rem, 4vw, 2.3rem); line-height: 1.15; letter-spacing: -.02em; margin: 0 0 .4rem; }
h2 { font-size: 1.35rem; letter-spacing: -.01em; margin: 3rem 0 .9rem; }
.lead { font-size: 1.06rem; color: var(--soft); max-width: 46rem; margin: 0; }
nav { display: flex; flex-wrap: wrap; gap: .2rem 1.3rem; margin-top: 1rem; padding-bottom: .8rem;
  border-bottom: 1px solid var(--line); }
nav a { color: var(--accent); text-decoration: none; } nav a:hover { text-decoration: underline; }
main > section:first-child h2 { margin-top: 1.6rem; }
main p { max-width: 50rem; }
.card, details { background: var(--card); border: 1px solid var(--line); border-radius: 10px;
  padding: clamp(.7rem, 2vw, 1.2rem); margin: 0 0 1rem; }
.grid { display: grid; gap: 1rem; margin-bottom: 1.4rem; grid-template-columns: repeat(var(--columns), minmax(0, 1fr)); }
.grid > * { margin: 0; min-width: 0; }
figure { margin: 0; }
.chart svg { display: block; width: 100%; height: auto; }
.wide { overflow-x: auto; overscroll-behavior-x: contain; }
.wide.hides { -webkit-mask-image: var(--fade); mask-image: var(--fade); --fade: linear-gradient(to left, transparent, #000 4rem); }
.cue { display: none; margin: 0 0 .3rem; font-size: .82rem; color: var(--accent); } .cue.shown { display: block; }
.wide th:first-child, .wide td:first-child { position: sticky; left: 0; background: var(--card); z-index: 1; }
.wide tr.best td:first-child { background: var(--tint); }
.wide.scrolled :is(th, td):first-child::after { content: ""; position: absolute; top: 0; bottom: 0; left: 100%; width: 2rem;
  background: linear-gradient(to right, var(--card), transparent); pointer-events: none; }
.wide.scrolled tr.best td:first-child::after { background: linear-gradient(to right, var(--tint), transparent); }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; width: 100%; }
th { font-weight: 600; font-size: .82rem; color: var(--soft); vertical-align: bottom; }
th, td { padding: .3em .8em; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
td.text { white-space: normal; min-width: 12rem; }
th:first-child, td:first-child { text-align: left; padding-left: .4em; }
tr.best td { background: var(--tint); font-weight: 600; }
tr.rule td { border-top: 2px solid var(--line); }
.dot { display: inline-block; width: .65em; height: .65em; border-radius: 50%; margin-right: .5em; }
.pixels { image-rendering: pixelated; display: block; max-width: none; border-radius: 3px; }
.pictures { width: auto; } .pictures th { font-size: .95rem; color: var(--ink); text-align: left; }
.pictures th, .pictures td { border: 0; padding: .15rem .35rem; } .pictures td { text-align: left; }
.pictures tbody th { color: var(--soft); font-size: .85rem; font-weight: 400; vertical-align: top; padding-right: .6rem; }
.facts { display: grid; gap: .7rem; grid-template-columns: repeat(var(--columns), minmax(0, 1fr)); margin: 1rem 0; }
.fact { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: .7rem 1rem; }
.fact b { display: block; font-size: 1.55rem; letter-spacing: -.02em; font-variant-numeric: tabular-nums; }
.fact span { color: var(--soft); font-size: .9rem; }
details { padding: 0; } summary { cursor: pointer; font-weight: 600; padding: .8rem 1.2rem; }
details > :not(summary) { padding: 0 1.2rem 1.1rem; }
code { background: var(--tint); padding: 0 .25em; border-radius: 3px; }
.growing button { font: inherit; cursor: pointer; }
main { padding-bottom: 3rem; }
@media (max-width: 900px) { .grid { grid-template-columns: minmax(0, 1fr); } }
@media (max-width: 760px) { .facts { grid-template-columns: 1fr 1fr; } .fact { padding: .6rem .7rem; } }
@media (max-width: 600px) { th, td { padding: .3em .5em; }
  .pictures, .pictures tbody, .pictures tr, .pictures th, .pictures td { display: block; } .pictures thead { display: none; }
  .pictures tbody th { font-weight: 600; color: var(--ink); padding-top: .9rem; }
  .pictures td::before { content: attr(data-name); display: block; color: var(--soft); font-size: .85rem; }
  .pictures .pixels { max-width: 100%; height: auto; } }
"""

# Says of what is wider than its place that more is to be seen, and fades it out where it is cut off.
SCRIPT = """
(function () {
  var update = function () {
    document.querySelectorAll(".wide").forEach(function (wide) {
      wide.classList.toggle("hides", wide.scrollLeft + wide.clientWidth < wide.scrollWidth - 1);
      wide.classList.toggle("scrolled", wide.scrollLeft > 1);
      wide.previousElementSibling.classList.toggle("shown", wide.clientWidth < wide.scrollWidth - 1);
    });
  };
  document.querySelectorAll(".wide").forEach(function (wide) { wide.addEventListener("scroll", update, {passive: true}); });
  document.querySelectorAll("details").forEach(function (part) { part.addEventListener("toggle", update); });
  addEventListener("resize", update);
  update();
})();
"""


def samples(count):
    return f"{count} sample{'' if count == 1 else 's'} per pixel"


def paragraph(text):
    return f"<p>{html.escape(text)}</p>"


def sideways(inside):
    """HTML that scrolls in its place where that is too narrow, and says so."""
    return f"<p class=cue aria-hidden=true>&#8596; Scroll sideways for more</p><div class=wide tabindex=0>{inside}</div>"


def table(header, rows, highlighted=(), rules=(), colours=None):
    """Rows of strings. highlighted: indices of rows to highlight; rules: indices of rows with a line above.

    colours: {text of a first cell: colour of a dot before it}.
    """
    highlighted, rules, rows = set(highlighted), set(rules), [list(map(str, row)) for row in rows]
    # Wrap sentences, not figures.
    wraps = [max((len(row[i]) for row in rows), default=0) > 40 for i in range(len(header))]

    def cell(i, text):
        dot = f'<span class=dot style="background:{colours[text]}"></span>' if not i and text in (colours or {}) else ""
        return f"<td{' class=text' if wraps[i] else ''}>{dot}{html.escape(text)}</td>"

    body = []
    for i, row in enumerate(rows):
        kinds = " ".join(name for name, those in (("best", highlighted), ("rule", rules)) if i in those)
        opening = f'<tr class="{kinds}">' if kinds else "<tr>"
        body.append(opening + "".join(cell(*pair) for pair in enumerate(row)) + "</tr>\n")
    head = "".join(f"<th>{html.escape(str(text))}</th>" for text in header)
    whole = f"<table><thead><tr>{head}</tr></thead>\n<tbody>{''.join(body)}</tbody></table>"
    return f"<div class=card>{sideways(whole)}</div>"


def image(picture, alt, factor=1):
    """A Pillow image, each pixel shown as factor x factor page pixels."""
    data = io.BytesIO()
    picture.save(data, "PNG", optimize=True)
    source = base64.b64encode(data.getvalue()).decode()
    return (f'<img class=pixels width={factor * picture.width} height={factor * picture.height} alt="{html.escape(alt)}" '
            f'src="data:image/png;base64,{source}">')


def pictures(cells, row_names, column_names):
    """A grid of Pillow images, cells[row][column]. In a narrow window the pictures are stacked, each under its name."""
    head = "".join(f"<th>{html.escape(name)}</th>" for name in column_names)
    room = 1080 // max(1, len(column_names))
    body = ""
    for name, row in zip(row_names, cells):
        factor = max(1, room // max(cell.width for cell in row))
        inside = "".join(f'<td data-name="{html.escape(column)}">{image(cell, f"{name}, {column}", factor)}</td>'
                         for cell, column in zip(row, column_names))
        body += f"<tr><th>{html.escape(name)}</th>{inside}</tr>\n"
    whole = f"<table class=pictures><thead><tr><th></th>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f"<figure>{sideways(whole)}</figure>"


def svg(figure):
    """A Matplotlib figure as SVG."""
    data = io.StringIO()
    figure.savefig(data, format="svg", transparent=True)
    return data.getvalue()


def chart(figure):
    """A Matplotlib figure or SVG text, scaled to the available width."""
    text = figure if isinstance(figure, str) else svg(figure)
    return f'<figure class="card chart">{text[text.index("<svg"):]}</figure>'


def grid(parts):
    """Parts side by side in full rows where there is room, else one below the other."""
    parts = list(parts)
    columns = 3 if len(parts) % 3 == 0 else min(2, len(parts))
    return f'<div class=grid style="--columns:{columns}">{"".join(parts)}</div>'


def facts(pairs, columns=4):
    """A strip of headlines: pairs of (short value, caption)."""
    inside = "".join(f"<div class=fact><b>{html.escape(value)}</b><span>{html.escape(what)}</span></div>"
                     for value, what in pairs)
    return f'<div class=facts style="--columns:{columns}">{inside}</div>'


def folded(summary, parts, shown=False):
    """Parts below a line that shows and hides them."""
    return (f"<details{' open' if shown else ''}><summary>{html.escape(summary)}</summary><div>{''.join(parts)}</div>"
            "</details>")


def still_growing(text):
    """A notice on a page whose program has not ended: loads the page again every few seconds until the visitor uses it, and
    then offers a button."""
    return (f'<p class="card growing" role=status>{html.escape(text)} <button type=button hidden>Load what there is now</button></p>'
            """<script>
(function () {
  var button = document.querySelector(".growing button"), timer = setInterval(function () { location.reload(); }, 5000);
  button.addEventListener("click", function () { location.reload(); });
  ["pointerdown", "keydown", "wheel", "touchstart"].forEach(function (used) {
    addEventListener(used, function () { clearInterval(timer); button.hidden = false; }, {passive: true});
  });
})();
</script>""")


def page(title, sections, lead=""):
    """The whole page. sections: pairs of (heading, list of parts); lead: a sentence or two."""
    links = "".join(f'<a href="#part-{i}">{html.escape(heading)}</a>' for i, (heading, _) in enumerate(sections))
    body = "\n".join(f'<section id="part-{i}"><h2>{html.escape(heading)}</h2>\n' + "\n".join(parts) + "</section>"
                     for i, (heading, parts) in enumerate(sections))
    return (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style></head>\n'
            f"<body><header><h1>{html.escape(title)}</h1>{f'<p class=lead>{html.escape(lead)}</p>' if lead else ''}"
            f"<nav>{links}</nav></header>\n<main>{body}</main>\n<script>{SCRIPT}</script></body></html>\n")
