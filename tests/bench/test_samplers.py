# SPDX-License-Identifier: Apache-2.0
"""The report on samplers and its programs: OpenQMC's samplers are in all tables and plots, or in none."""

import csv
import io
import subprocess
import sys

import numpy as np
import pytest
from report.base import peers
from report.base.files import write_rows
from report.samplers import samplers


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
    names = ",".join(("blue", "white", *there))
    rows = samplers.run_bench(programs["bench_samplers"], ["--max-spp", "1", "--domains", "2", "--figures", "steps",
                                                            "--samplers", names])
    # openqmc-sobolbn has "sobol" in it.
    assert samplers.names_in(rows) == ["white", "blue", *there]
    found = {row["sampler"]: float(row["rmse"]) for row in rows if row["sigma"] == "2.1"}
    # What a Gaussian along one axis leaves of the deviation of a step, which is at most a half.
    assert 0.1 < found["white"] < 0.5 / np.sqrt(2 * np.sqrt(np.pi) * 2.1)
    assert all(found[name] < 0.9 * found["white"] for name in ("blue", *there))


def test_every_figure_is_measured(programs):
    rows = samplers.run_bench(programs["bench_samplers"], ["--max-spp", "2", "--domains", "2",
                                                            "--samplers", "sobol,zorder,blue"])
    assert {row["figure"] for row in rows} == set(samplers.FIGURES) and {row["spp"] for row in rows} == {"1", "2"}
    for figure in samplers.FIGURES:
        # In the pixel blue is about as good as sobol, or a little better.
        assert 0.9 < samplers.ratios(rows, "blue", figure, "0.0")[2] < 1.03
        for name, most in (("blue", 0.8), ("zorder", 0.95)):
            blurred = samplers.ratios(rows, name, figure, "2.1")
            assert all(0.1 < ratio < most for ratio in blurred.values()), (figure, name)


def test_samples_are_uniform_and_differ(programs, pathtracer):
    drawn = [samplers.draw_samples(programs["bench_samplers"], name, 2)
             for name in ("white", "sobol", "sobol4d", "zorder", *peers.listed(pathtracer))]
    for samples in drawn:
        assert samples.min() >= 0 and samples.max() < 1
        # Of 2 * 16384 independent numbers the mean scatters by 0.0016; there are 16 domains and 4 dimensions.
        np.testing.assert_allclose(samples.mean(axis=(1, 2, 3)), 0.5, atol=0.0075)
        assert len({own.tobytes() for own in samples}) == samplers.DOMAINS
    assert len({samples.tobytes() for samples in drawn}) == len(drawn)


def test_streaks_show_in_both_measures_of_isotropy():
    rng = np.random.default_rng(5)
    even = rng.random((samplers.DOMAINS, samplers.SIZE, samplers.SIZE, 1, 4), np.float32)
    assert samplers.axes_ratio(even) < 1.1  # of 192 ratios that scatter by a fifth each
    streaks = even.copy()
    streaks[:, 1::2] = streaks[:, ::2]  # rows in pairs: less even along columns
    streaks[..., 1::2] = even[..., 1::2]
    assert samplers.axes_ratio(streaks) > 1.3
    power = np.exp(rng.standard_normal((samplers.SIZE, samplers.SIZE)) / 10)
    along = np.abs(np.fft.fftfreq(samplers.SIZE))
    cross = power * np.where(np.minimum(along[:, None], along) < 0.2 * np.maximum(along[:, None], along), 0.5, 1)
    assert max(samplers.anisotropy(power)[1]) < -25 and min(samplers.anisotropy(cross)[1]) > -15


@pytest.mark.parametrize("arguments", [["--samples", "pink", "1"], ["--samples", "blue", "0"], ["--peer", "x=y"],
                                       ["--max-spp", "0"], ["--max-spp", "4x"], ["--domains", "17"], ["--figures"]])
def test_wrong_arguments_get_the_usage(programs, arguments):
    done = subprocess.run([programs["bench_samplers"], *arguments], check=False, capture_output=True, text=True)
    assert done.returncode == 2 and done.stdout == "" and done.stderr.startswith("usage: bench_samplers")


def rows_of(names):
    """Rows in the format of bench_samplers, with synthetic errors."""
    rows = [{"sampler": name, "figure": figure, "spp": str(spp), "sigma": sigma, "rmse": f"{0.1 / spp / (1 + k)}"}
            for k, name in enumerate(names) for figure in samplers.FIGURES for spp in (1, 4, 16, 64)
            for sigma in samplers.BLURS]
    draws = [{"sampler": name, "form": "peer" if name in peers.PEERS else "inline", "nanoseconds": f"{10 * k + 10}",
              "instances": "1"} for k, name in enumerate(names)]
    return rows, draws


# Replaces both benchmarks: prints a file beside it, or random samples.
FAKE = """#!{python}
import sys, pathlib
import numpy as np
if "--samples" in sys.argv:
    spp = int(sys.argv[-1])
    sys.stdout.buffer.write(np.random.default_rng(1).random((2, 128, 128, spp, 4), np.float32).tobytes())
else:
    lines = pathlib.Path(__file__).with_suffix(".csv").read_text().splitlines()
    wanted = sys.argv[sys.argv.index("--samplers") + 1] if "--samplers" in sys.argv else None
    print("\\n".join(line for line in lines if line == lines[0] or wanted in (None, line.split(",")[0])))
"""


@pytest.mark.parametrize("others", [(), peers.PEERS])
def test_peers_stand_in_every_table_and_plot_or_in_none(tmp_path, monkeypatch, others):
    rows, draws = rows_of(("white", "sobol", "blue", *others))
    for name, table in (("rows", rows), ("draws", draws)):
        write_rows(tmp_path / f"{name}.csv", list(table[0]), table)
        (tmp_path / name).write_text(FAKE.format(python=sys.executable))
        (tmp_path / name).chmod(0o755)
    legends = []

    def closed(figure):
        found = [*figure.legends, *(axis.get_legend() for axis in figure.axes if axis.get_legend())]
        legends.append({text.get_text() for legend in found for text in legend.get_texts()})
        figure.clear()

    monkeypatch.setattr(samplers.plt, "close", closed)
    monkeypatch.setattr(samplers, "SPECTRA_COUNTS", (1, 2))
    monkeypatch.setattr(samplers, "DOMAINS", 2)
    monkeypatch.setattr(peers, "listed", lambda program: peers.PEERS)
    words = ["samplers", "--quick", "--program", str(tmp_path / "rows"), "--draws", str(tmp_path / "draws"), "--out",
             str(tmp_path / "out"), "--pages", str(tmp_path / "pages"), *(["--openqmc", "/some/where"] if others else [])]
    monkeypatch.setattr(sys, "argv", words)
    samplers.main()

    assert len(legends) == 2 and all(legend == {"white", "blue", "sobol", *others} for legend in legends)
    text = (tmp_path / "out" / "samplers.md").read_text()
    tables = text.split("| sampler |")[1:]
    assert len(tables) == 2 + 10 * 4  # axes and times, ten figures with three blurs and the mean
    for name in peers.PEERS:
        assert all((f"| {name} |" in part) == (name in others) for part in tables)
    assert ("`scripts/bench samplers --quick --openqmc DIR`" in text) == bool(others)
    assert ("| best of OpenQMC |" in text) == bool(others)
    assert "/some/where" not in text
    # White's errors are twice sobol's, and blue's two thirds.
    assert sum("| white | 2.00 | 2.00 | 2.00 | 2.00 |" in part and "| blue | 0.67 |" in part for part in tables) >= 20
    measured = list(csv.DictReader(io.StringIO((tmp_path / "pages" / "samplers_draws.csv").read_text())))
    assert [row["sampler"] for row in measured] == [row["sampler"] for row in draws]

    monkeypatch.setattr(samplers, "run_bench", None)  # measures nothing
    monkeypatch.setattr(sys, "argv", [*words, "--again"])
    samplers.main()
    assert (tmp_path / "out" / "samplers.md").read_text() == text


@pytest.mark.parametrize("others", [(), peers.PEERS])
def test_every_count_has_a_page_and_a_plot(tmp_path, monkeypatch, others):
    rows, _ = rows_of(("white", "sobol", "zorder", "blue", *others))
    (tmp_path / "rows.csv").write_text("")
    write_rows(tmp_path / "rows.csv", list(rows[0]), rows)
    (tmp_path / "rows").write_text(FAKE.format(python=sys.executable))
    (tmp_path / "rows").chmod(0o755)
    monkeypatch.setattr(peers, "listed", lambda program: peers.PEERS)
    words = ["samplers", "--every", "--program", str(tmp_path / "rows"), "--out", str(tmp_path / "out"), "--pages",
             str(tmp_path / "pages"), *(["--openqmc", str(tmp_path)] if others else [])]
    monkeypatch.setattr(sys, "argv", words)
    samplers.main()
    text = (tmp_path / "out" / "samplers_every.md").read_text()
    assert (tmp_path / "out" / "samplers_spp.png").is_file()
    assert text.count("| sobol (padded) | 1.000 |") == len(samplers.EVERY)
    assert all((f"| {name} |" in text) == (name in others) for name in peers.PEERS)
    monkeypatch.setattr(samplers, "run_bench", None)  # measures nothing
    monkeypatch.setattr(sys, "argv", [*words, "--again"])
    samplers.main()
    assert (tmp_path / "out" / "samplers_every.md").read_text() == text


def test_nothing_measured_before_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["samplers", "--again", "--pages", str(tmp_path)])
    with pytest.raises(SystemExit, match=r"samplers.csv: No such file.*; measure first, without --again"):
        samplers.main()
