# SPDX-License-Identifier: Apache-2.0
"""Compares figures quoted in README.md and docs/ with the CSV files in evidence/results."""

import re
import statistics
from pathlib import Path

import bluenoise
from evidence.base.files import read_numbers
from evidence.renders import times
from evidence.renders.renders import HEADLINE, TO_WHITE
from evidence.summary import summary

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "evidence" / "results"


def quoted(page, pattern):
    """The numbers in the only match of a pattern. A space matches a line break, and # a number."""
    text = " ".join((ROOT / page).read_text(encoding="utf-8").replace("**", "").split())
    (found,) = re.finditer(pattern.replace("#", r"(\d+(?:\.\d+)?)"), text)
    return [float(number) for number in found.groups()]


def percent(*values):
    return [float(f"{100 * (1 - value):.0f}") for value in values]


def rounded(values, digits):
    return [float(f"{value:.{digits}f}") for value in values]


def test_samples_to_match_white_noise():
    found = summary.read(RESULTS / "renders.csv")
    counts = rounded((16 * found[TO_WHITE, "", label, 16].value for label in ("blue", "sobol")), 1)
    assert quoted("README.md", "# samples per pixel with the `blue` sampler match # with padded") == counts


def test_errors_at_several_counts():
    found = summary.read(RESULTS / "renders.csv")
    for label, text in (("blue", "ties for it: #, #, # and # at 1, 4, 16 and 64 samples"), ("openqmc-latticebn", "`latticebn`, has errors of #, #, # and #"),
                        ("sobol-global", "Global Sobol' has errors of #, #, # and #")):
        assert quoted("docs/which.md", text) == rounded((found[HEADLINE, "", label, spp].value for spp in (1, 4, 16, 64)), 2)


def test_cpu_time_until_noise_is_invisible():
    stopped = {(row["scene"], row["sampler"]): row for row in read_numbers(RESULTS / "stop.csv") if (row["what"], row["at"]) == ("--visible-noise", 1)}
    labels = ("blue", "sobol", "white")
    scenes = [scene for scene in {scene for scene, _ in stopped} if all(stopped[scene, label]["capped"] <= 0.05 for label in labels)]
    cost = times.over(read_numbers(RESULTS / "times.csv"), "blue")
    shares = [statistics.geometric_mean(stopped[scene, "blue"]["samples"] / stopped[scene, base]["samples"] for scene in scenes) / cost[base]
              for base in labels[1:]]
    assert quoted("README.md", "takes #% less CPU time than padded Sobol' and #% less than white noise, averaged over the # scenes") == [*percent(*shares), len(scenes)]


def test_visible_noise_is_within_its_limits():
    """The figures of docs/stop.md, and that they are good enough to stop by."""
    rows = read_numbers(RESULTS / "stop.csv")
    left = max(row["noise_95"] for row in rows if (row["what"], row["at"]) == ("--visible-noise", 1) and row["capped"] <= 0.05)
    ratios = [row["estimate"] / row["noise"] for row in rows if row["what"] == "estimate" and row["at"] >= 8]
    within = statistics.mean(0.8 <= ratio <= 1.5 for ratio in ratios)
    assert left < 1.3 and min(ratios) > 0.7 and within > 0.95
    assert quoted("docs/stop.md", "95% of its blocks had a true noise of at most # steps") == rounded([left], 2)
    assert quoted("docs/stop.md", "From 8 samples on, #% of # estimates are 0.8 to 1.5 times the true noise; the lowest is # times and the highest # times"
                  ) == [round(100 * within), len(ratios), *rounded([min(ratios), max(ratios)], 2)]


def test_error_over_fast():
    """FAST's errors are stored with two digits, so the README quotes a range."""
    found = {row["way"]: row["error"] for row in read_numbers(RESULTS / "realtime.csv")
             if (row["integrand"], row["outcome"], row["filter"]) == ("half-plane", "average, 0.1", "sigma 1.0")}
    ends = percent(found["blue"] / (found["FAST"] - 0.005), found["blue"] / (found["FAST"] + 0.005))
    assert quoted("README.md", "`blue` has # to #% lower error than FAST") == ends


def test_gain_before_a_denoiser():
    found = summary.read(RESULTS / "denoise.csv")
    counts = (1, 2, 4, 16)
    own, blurred = ([found[measure, "", "blue", spp] for spp in counts] for measure in ("plain:displayed", "plain:displayed_2.1"))
    assert all(each.significant for each in own)
    assert quoted("docs/faq.md", "At 1, 2, 4 and 16 samples, the denoised image has #%, #%, #% and #% lower error") == percent(*(each.value for each in own))
    assert quoted("docs/faq.md", "the gain is #%, #% and #% at 1, 4 and 16 samples") == percent(*(blurred[i].value for i in (0, 2, 3)))
    assert blurred[2].significant and blurred[3].significant


def test_citations_name_the_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    version, year = (re.search(rf"^{key}: (\S+)", citation, re.MULTILINE)[1] for key in ("version", "date-released"))
    assert version == bluenoise.__version__
    assert f"version = {{{version}}}, year = {{{year[:4]}}}}}`." in (ROOT / "README.md").read_text(encoding="utf-8").splitlines()[-1]
