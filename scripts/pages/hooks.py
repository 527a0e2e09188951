# SPDX-License-Identifier: Apache-2.0
"""MkDocs hooks (mkdocs.yml): the site mirrors the folders of the repository, so that links work both there and on code hosts.

Pages in the navigation are files in the repository, and Doxygen writes reference/ from the headers. A link to any other file or folder in
the repository opens a page that shows it.
"""

import logging
import re
import subprocess
import sys
from pathlib import Path

from mkdocs.structure.files import File, Files, InclusionLevel

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from pages import links  # noqa: E402

log = logging.getLogger("mkdocs.hooks.pages")

LANGUAGES = {".h": "c", ".c": "c", ".hpp": "cpp", ".cpp": "cpp", ".glsl": "glsl", ".hlsl": "hlsl", ".wgsl": "wgsl",
             ".metal": "cpp", ".cu": "cuda", ".py": "python", ".txt": "text",
             ".toml": "toml", ".csv": "text", ".yml": "yaml"}
ASSETS = {"assets/site.css": "site.css", "assets/iframe-worker.js": "search_from_disk.js"}
# The live page sends its height.
FRAME_SCRIPT = ("addEventListener('message',e=>{const f=document.querySelector('.live iframe');"
                "if(f&&e.source===f.contentWindow&&e.data.height>0)f.style.height=e.data.height+2+'px'})")
# Two images in a <div class="compare"> lie on each other; a slider moves the border between them.
COMPARE_SCRIPT = ("for(const c of document.querySelectorAll('.compare')){const r=document.createElement('input');r.type='range';"
                  "r.ariaLabel='Share of the first image';r.oninput=()=>c.style.setProperty('--first',r.value+'%');c.append(r)}")
LARGEST = 100_000  # maximum size, in bytes, of a file that is shown


# ---- Pages made from files


def text_of(path):
    data = (ROOT / path).read_bytes()
    if len(data) > LARGEST or b"\0" in data:
        log.warning("%s is linked to but cannot be shown: it is binary or has %d bytes", path, len(data))
        return ""
    return data.decode("utf-8")


def escaped(text):
    return re.sub(r"([\\`*_{}\[\]>#])", r"\\\1", text)


def listing(path, level=1):
    """A file as a code block under its path."""
    text = text_of(path)
    fence = "`" * max(3, 1 + max(map(len, re.findall(r"`+", text)), default=0))
    return f"{'#' * level} {escaped(path)}\n\n{fence}{LANGUAGES.get(Path(path).suffix, 'text')}\n{text.rstrip()}\n{fence}\n"


def folder_page(path):
    files = sorted(file.relative_to(ROOT).as_posix() for file in (ROOT / path).rglob("*")
                   if file.is_file() and "__pycache__" not in file.parts and not file.name.startswith("."))
    return f"# {escaped(path)}\n\n" + "\n".join(listing(file, 2) for file in files)


# ---- Hooks


def pages(nav):
    """The paths in a part of the navigation."""
    for entry in nav if isinstance(nav, list) else nav.values() if isinstance(nav, dict) else [nav]:
        yield from [entry] if isinstance(entry, str) else pages(entry)


def on_files(files, config):
    """Replaces the files that MkDocs found in docs/, except the theme's, with the repository's files that the site needs."""
    site = Files([file for file in files if file.src_dir != config.docs_dir])
    shown, others = set(), []

    def page(path, inclusion):
        file = ROOT / path
        if file.is_file():
            new, text = File.generated(config, path, abs_src_path=str(file), inclusion=inclusion), file.read_text(encoding="utf-8")
        elif path.endswith(".md") and (ROOT / path[:-3]).exists():
            show = folder_page if (ROOT / path[:-3]).is_dir() else listing
            text = show(path[:-3])
            new = File.generated(config, path, content=text, inclusion=inclusion)
        else:
            return  # MkDocs warns about the entry
        site.append(new)
        shown.add(path)
        for target in links.links(text):
            if not links.is_external(target):
                linked, _ = links.resolve(path, target)
                if not linked.endswith(".md") and (ROOT / linked).exists() and linked not in others:
                    others.append(linked)

    for path in pages(config.nav):
        page(path, InclusionLevel.INCLUDED)
    static = [*(ROOT / "docs").rglob("*"), *(ROOT / "evidence" / "results").rglob("*")]
    live = ROOT / config.extra["live_page"]
    if live.is_file():
        subprocess.run([sys.executable, live.parent / "package" / "make_texts.py"], check=True)
        static += (file for file in live.parent.rglob("*") if file.suffix != ".py")
    for file in static:
        path = file.relative_to(ROOT).as_posix()
        if file.is_file() and file.suffix != ".md":
            site.append(File.generated(config, path, abs_src_path=str(file)))
        elif file.is_file() and path not in shown and path.startswith(("docs/", "evidence/results/")):
            log.warning("%s is not in the navigation of mkdocs.yml", path)
    for path in others:
        if f"{path}.md" not in shown and not site.get_file_from_path(path):
            page(f"{path}.md", InclusionLevel.NOT_IN_NAV)
    subprocess.run(["doxygen", "scripts/pages/Doxyfile"], cwd=ROOT, check=True)
    for file in filter(Path.is_file, (ROOT / "out/reference").rglob("*")):
        site.append(File.generated(config, file.relative_to(ROOT / "out").as_posix(), abs_src_path=str(file)))
    for path, name in ASSETS.items():
        site.append(File.generated(config, path, abs_src_path=str(ROOT / "scripts/pages" / name)))
    return site


def on_page_markdown(markdown, page, config, files):
    """Redirects links to files that have their own page to that page."""
    path = page.file.src_uri
    for target in set(links.links(markdown)):
        linked, _ = links.resolve(path, target)
        if not links.is_external(target) and not files.get_file_from_path(linked) and files.get_file_from_path(f"{linked}.md"):
            address, *anchor = target.split("#")
            markdown = markdown.replace(f"]({target})", f"]({'#'.join([address.rstrip('/') + '.md', *anchor])})")
    # Searches rank guides first, then measurements, then files that are only linked.
    rank = 0.05 if path not in pages(config.nav) else 0.2 if path.startswith("evidence/") else 1 if "/" not in path else 5
    page.meta.setdefault("search", {"boost": rank})
    if page.is_homepage:
        # The navigation would contain only this page, and the live page takes the place of the table of contents.
        page.meta["hide"] = ["navigation", "toc"]
    live = config.extra["live_page"]
    if page.is_homepage and files.get_file_from_path(live):
        frame = (f'\n<div class="live" markdown="1">\n<iframe src="{live}" title="{config.site_description}, live"></iframe>\n'
                 f"<script>{FRAME_SCRIPT}</script>\n\n[Open it alone]({live})\n</div>\n")
        markdown = re.sub(r"^# .*\n", lambda heading: heading[0] + frame, markdown, count=1, flags=re.M)
    if 'class="compare"' in markdown:
        markdown += f"\n<script>{COMPARE_SCRIPT}</script>\n"
    return markdown


def on_page_content(html, page, config, files):
    """Makes images open in full size when clicked."""
    return re.sub(r'<p>(<img [^>]*?src="([^"]+)"[^>]*>)</p>', r'<p><a href="\2">\1</a></p>', html)


def on_post_page(output, page, config):
    """Warns about resources that a browser would load from other hosts, which fails a strict build."""
    element = r"<(?:script|img|iframe|source|video|link(?![^>]*rel=\"canonical\"))"
    loaded = re.findall(element + r"\b[^>]*?(?:src|href)=\"?((?:https?:)?//[^\"\s>]+)", output)
    for address in loaded:
        log.warning("%s loads %s", page.file.src_uri, address)
    return output
