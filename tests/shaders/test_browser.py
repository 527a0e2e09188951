# SPDX-License-Identifier: Apache-2.0
"""Draws and choices in a browser equal the library's: WGSL in WebGPU and GLSL in WebGL 2, in software, in headless Chromium."""

import http.server
import os
import shutil
import subprocess
import threading

import pytest
from conftest import HERE, need
from test_shaders import compare, wgsl, with_texts

# SwiftShader, its renderer in software, is not meant for pages that nobody trusts.
OPTIONS = ["--headless=new", "--disable-dev-shm-usage", "--no-first-run", "--enable-unsafe-webgpu", "--enable-unsafe-swiftshader",
           "--use-webgpu-adapter=swiftshader", "--use-angle=swiftshader"]


KINDS = {"/": "text/html; charset=utf-8", ".js": "text/javascript"}


def posted_by(served, profile):
    """What the page served["/"] posts until it posts to /end, {path: bytes}."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    need(chromium, "Chromium")
    results, ended = {}, threading.Event()

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.answer(served.get(self.path))

        def do_POST(self):
            results[self.path] = self.rfile.read(int(self.headers["Content-Length"]))
            self.answer(b"")
            if self.path == "/end":
                ended.set()

        def answer(self, body):
            self.send_response(404 if body is None else 200)
            kind = next((kind for end, kind in KINDS.items() if self.path.endswith(end)), "application/octet-stream")
            self.send_header("Content-Type", kind)
            self.end_headers()
            self.wfile.write(body or b"")

        def log_message(self, *_):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        root = ["--no-sandbox"] if os.geteuid() == 0 else []  # Chromium has no sandbox for root
        browser = subprocess.Popen([chromium, *OPTIONS, *root, f"--user-data-dir={profile}",
                                    f"http://127.0.0.1:{server.server_port}/"],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            assert ended.wait(300), f"the page did not end; it posted {sorted(results)}"
        finally:
            browser.terminate()
            browser.wait()
            server.shutdown()
    return results


@pytest.fixture(scope="module")
def posted(cases, tmp_path_factory):
    """What browser.html posts, {path: bytes}."""
    served = {"/": (HERE / "browser.html").read_bytes(), "/harness.js": (HERE / "harness.js").read_bytes(),
              "/draw.wgsl": wgsl().encode(), "/cdf": cases.cdf.tobytes(),
              "/words": cases.words.tobytes(),
              "/draw.frag": with_texts((HERE / "draw.frag").read_text()).encode()}
    for seed in range(3):
        served[f"/cases{seed}"] = cases.asked[seed].tobytes()
    return posted_by(served, tmp_path_factory.mktemp("profile"))


@pytest.mark.parametrize("name", ["webgpu", "webgl"])
def test_browser(posted, cases, name):
    seeds = iter(range(3))

    def run_shader(code, buffers, result_size, threads):
        result = posted[f"/{name}{next(seeds)}"]
        assert len(result) == result_size, result[:2000].decode()
        return result

    compare(run_shader, None, cases)
