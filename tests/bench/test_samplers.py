# SPDX-License-Identifier: Apache-2.0
"""The report on samplers and the programs behind it: OpenQMC's samplers stand in every table and plot, or in none."""

import csv
import io
import subprocess
import sys

import numpy as np
import pytest
from report import peers, samplers


@pytest.fixture
def programs(pathtracer):
    folder = pathtracer.parents[2] / "tests" / "bench"
    if not (folder / "bench_samplers").is_file():
        pytest.skip(f"no benchmarks in {folder}; run scripts/setup")
    return {name: folder / name for name in ("bench_samplers", "bench_draws")}


def test_draws_are_timed_in_every_form(programs, pathtracer):
    rows = samplers.run_bench(programs["bench_draws"], ["--rounds", "1"])
    assert {row["sampler"] for row in rows if row["form"] == "peer"} == set(peers.listed(pathtracer))
    assert {row["sampler"] for row in rows if row["form"] == "inline"} == {"blue", "sobol", "white"}
    assert all(0 < float(row["nanoseconds"]) < 1e6 and row["instances"] == "1" for row in rows)


def test_samplers_are_measured_by_name(programs, pathtracer):
    there = peers.listed(pathtracer)
    options = ["--max-spp", "1", "--families", "half-planes", "--pairs", "01"]
    rows = samplers.run_bench(programs["bench_samplers"], [*options, "--samplers", ",".join(("blue", *there))])
    # openqmc-sobolbn has "sobol" in it.
    assert samplers.names_in(rows) == ["white", "blue", *there]
    blurred = {row["sampler"]: float(row["ratio"]) for row in rows if row["sigma"] == "2.1"}
    assert blurred["white"] == 1 and all(blurred[name] < 0.7 for name in ("blue", *there))


def test_samples_are_uniform_and_differ(programs, pathtracer):
    drawn = [samplers.draw_samples(programs["bench_samplers"], name, 2)
             for name in ("white", "sobol", *peers.listed(pathtracer))]
    for samples in drawn:
        assert samples.min() >= 0 and samples.max() < 1
        # Of 2 * 65536 independent numbers the mean scatters by 0.0008.
        np.testing.assert_allclose(samples.mean(axis=(0, 1, 2)), 0.5, atol=0.004)
    assert len({samples.tobytes() for samples in drawn}) == len(drawn)


@pytest.mark.parametrize("arguments", [["--samples", "pink", "1"], ["--samples", "blue", "0"], ["--peer", "x=y"]])
def test_wrong_arguments_get_the_usage(programs, arguments):
    done = subprocess.run([programs["bench_samplers"], *arguments], check=False, capture_output=True, text=True)
    assert done.returncode == 2 and done.stdout == "" and done.stderr.startswith("usage: bench_samplers")


def rows_of(names):
    """Rows as bench_samplers prints them, with made-up errors."""
    rows = [{"sampler": name, "declared": "0", "family": family, "pair": pair, "spp": str(spp), "sigma": sigma,
             "rmse": f"{0.1 / spp / (1 + k)}", "ratio": f"{1 / (1 + k):.4f}"}
            for k, name in enumerate(names) for family, pair in (("half-planes", "01"), ("half-planes", "23"),
                                                                 ("wide", "01"), ("wide", "23"))
            for spp in (1, 4, 16, 64) for sigma in ("0.0", "1.0", "2.1")]
    draws = [{"sampler": name, "form": "peer" if name in peers.PEERS else "inline", "nanoseconds": f"{10 * k + 10}",
              "instances": "1"} for k, name in enumerate(names)]
    return rows, draws


# Stands in for both benchmarks: prints a file beside it, or random samples.
FAKE = """#!{python}
import sys, pathlib
import numpy as np
if "--samples" in sys.argv:
    spp = int(sys.argv[-1])
    sys.stdout.buffer.write(np.random.default_rng(1).random((256, 256, spp, 4), np.float32).tobytes())
else:
    print(pathlib.Path(__file__).with_suffix(".csv").read_text(), end="")
"""


@pytest.mark.parametrize("others", [(), peers.PEERS])
def test_peers_stand_in_every_table_and_plot_or_in_none(tmp_path, monkeypatch, others):
    rows, draws = rows_of(("white", "blue", "sobol", *others))
    for name, table in (("rows", rows), ("draws", draws)):
        samplers.write_rows(tmp_path / f"{name}.csv", table)
        (tmp_path / name).write_text(FAKE.format(python=sys.executable))
        (tmp_path / name).chmod(0o755)
    legends = []
    monkeypatch.setattr(samplers, "save", lambda figure, path: legends.append(
        {text.get_text() for axis in figure.axes if axis.get_legend() for text in axis.get_legend().get_texts()}))
    monkeypatch.setattr(peers, "listed", lambda program: peers.PEERS)
    monkeypatch.setattr(sys, "argv", [
        "samplers", "--quick", "--program", str(tmp_path / "rows"), "--draws", str(tmp_path / "draws"),
        "--out", str(tmp_path / "out"), *(["--openqmc", "/some/where"] if others else [])])
    samplers.main()

    assert len(legends) == 4 and all(legend == {"white", "blue", "sobol", *others} for legend in legends)
    text = (tmp_path / "out" / "samplers.md").read_text()
    tables = [part for part in text.split("\n## ") if "| sampler |" in part]
    assert len(tables) == 13  # times, and two families, two pairs, three blurs
    for name in peers.PEERS:
        assert all((f"| {name} |" in part) == (name in others) for part in tables)
    assert ("`scripts/bench samplers --quick --openqmc DIR`" in text) == bool(others)
    assert "/some/where" not in text
    measured = list(csv.DictReader(io.StringIO((tmp_path / "out" / "samplers_draws.csv").read_text())))
    assert [row["sampler"] for row in measured] == [row["sampler"] for row in draws]
