# SPDX-License-Identifier: Apache-2.0
"""The report on networks: rows of other networks, and a quick complete run."""

import argparse
import csv
import importlib.util
import os
import sys

import pytest
from PIL import Image
from report.masks import neural, neural_plane

import bluenoise

BUILTIN = neural.ROOT / "libbn/data/neural.onnx"


def test_costs_are_those_of_the_files():
    text = (neural.DATA / "README.md").read_text(encoding="utf-8")
    for file in neural.NETWORKS.values():
        assert f"| `{file}` | {(neural.DATA / file).stat().st_size:,} |" in text
    assert {name: neural.cost(file) for name, file in neural.NETWORKS.items()} == {
        "network": (940, 33), "fast network": (440, 18), "vector network": (1580, 18)}


class Plane:
    """A generator for machines with and without a GPU, which notes its windows."""

    has_gpu, windows = True, []

    def __init__(self, model=None, runtime=None, threads=0, provider=None):
        if provider == "cuda" and not self.has_gpu:
            raise bluenoise.RuntimeMissingError("no GPU")
        self.provider = provider

    def window(self, *place, seed):
        self.windows.append((self.provider, *place))


@pytest.mark.parametrize("has_gpu", [False, True])
@pytest.mark.parametrize("provider", [None, "cpu", "cuda"])
def test_endless_plane(monkeypatch, tmp_path, has_gpu, provider):
    monkeypatch.setattr(bluenoise, "NeuralGenerator", Plane)
    monkeypatch.setattr(Plane, "has_gpu", has_gpu)
    monkeypatch.setattr(Plane, "windows", [])
    options = argparse.Namespace(out=tmp_path, again=False, quick=True, provider=provider)
    if provider == "cuda" and not has_gpu:
        with pytest.raises(bluenoise.RuntimeMissingError):
            neural_plane.section({"network": None}, options)
        with pytest.raises(argparse.ArgumentTypeError, match="no GPU"):
            neural_plane.available(provider)
        return
    assert neural_plane.available(provider) == provider
    measured = has_gpu and provider != "cpu"
    lines = neural_plane.section({"network": None}, options)
    assert any("No GPU was measured" in line for line in lines) == (not measured)
    places = [place for name, *place in Plane.windows if name == "cuda"]
    assert places == [[256 * i, 0, 256, 256] for i in range(17 if measured else 0)]
    assert len([line for line in lines if line.startswith("| network | processor |")]) == len({1, os.cpu_count()})
    assert neural_plane.section({"network": None}, argparse.Namespace(**{**vars(options), "again": True})) == lines


def test_rate_of_a_plane():
    row = {"network": "n", "device": "GPU", "threads": "4", "extent": "1000", "windows": "3", "seconds": "0.002"}
    assert neural_plane.lines_of([row])[-1] == "| n | GPU | 4 | 0.667 | 1.5 |"


def test_rows_of_other_networks(tmp_path):
    path = tmp_path / "paper.csv"
    path.write_text("name,size,seconds,threads,e_1,e_1.5,flop_per_texel\n"
                    "perceptron,64,0.001,1,0.0865,0.0588,1600\nperceptron,96,0.001,1,0.0865,0.0588,1600\n")
    (row,) = neural.paper_rows(path, (64, 128))
    assert set(row) == set(neural.FIELDS) and row["width"] == 64 and float(row["e_1.5"]) == 0.0588
    assert "| perceptron | 1 ms | 1 ms | 244 ns | 1600 | 0.0865 | 0.0588 |" in neural.table([row])


@pytest.mark.skipif(importlib.util.find_spec("onnxruntime") is None or not BUILTIN.exists(), reason="no network to run")
def test_a_quick_run_writes_the_whole_report(tmp_path, monkeypatch, capsys):
    paper = tmp_path / "paper.csv"
    paper.write_text("name,size,seconds,threads,e_1,e_1.5,flop_per_texel\nperceptron,64,0.001,1,0.0865,0.0588,1600\n")
    guide = tmp_path / "guide.md"
    guide.write_text("before\n<!-- table: scripts/bench neural -->\nold\n<!-- end of the table -->\nafter\n")
    monkeypatch.setattr(sys, "argv", ["neural", "--quick", "--paper", str(paper), "--out", str(tmp_path / "report"),
                                      "--guide", str(guide)])
    neural.main()
    text = (tmp_path / "report/neural.md").read_text()
    assert text.rstrip("\n") in capsys.readouterr().out
    with open(tmp_path / "report/neural.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {"network", "fast network", "vector network", "relax", "void-and-cluster", "anneal", "white", "perceptron"} == {row["method"] for row in rows}
    for row in rows:
        assert float(row["seconds"]) > 0 and 0.03 < float(row["e_1"]) < 0.13
    table = guide.read_text().split("-->\n\n")[1].split("\n\n<!--")[0]
    assert table in text and "old" not in guide.read_text() and guide.read_text().endswith("-->\nafter\n")
    assert [line.split(" | ")[0][2:] for line in table.splitlines()[2:]] == [
        ", ".join(filter(None, (name, options))) for name, (options, *_) in neural.CHOICES.items()]
    assert Image.open(tmp_path / "report/neural.png").width > 800
    assert Image.open(tmp_path / "neural.png").height > 500
    monkeypatch.setattr(sys, "argv", [*sys.argv, "--again"])
    neural.main()
    assert (tmp_path / "report/neural.md").read_text() == text
    assert sorted(p.name for p in (tmp_path / "report").iterdir()) == ["neural.csv", "neural.md", "neural.png", "neural_plane.csv",
                                                                       "neural_vectors.csv"]


def test_the_readme_has_the_table_of_the_report():
    """Both are written by the same run."""
    table = (neural.ROOT / "docs" / "masks.md").read_text().split("<!-- table: scripts/bench neural -->\n\n")[1].split("\n\n<!--")[0]
    assert table.count("\n") > 4 and table in (neural.ROOT / "docs/report/neural.md").read_text()
