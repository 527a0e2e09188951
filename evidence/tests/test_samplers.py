# SPDX-License-Identifier: Apache-2.0
"""The measurements and programs behind scripts/bench samplers."""

import numpy as np
import pytest

from evidence.base.command import CommandError
from evidence.samplers import heitz, integrands, plugins, samplers, variants


def test_every_row_is_relative_to_padded_sobol():
    ways = {name: integrands.of_library(name) for name in ("white", "sobol", "zorder", "blue")}
    rows = {(row["row"], row["sampler"], row["spp"]): float(row["value"]) for row in samplers.measure_all(ways, 1, (1, 4))}
    for row in samplers.ROWS:
        assert rows[row, "sobol", 4] == 1 and 0.3 < rows[row, "blue", 4] < (1.1 if row.endswith("pixels") else 0.95), row
    assert 5 < rows[samplers.PEAKS, "white", 1] < 7 and rows[samplers.PEAKS, "blue", 1] < 8


def test_odd_sample_counts_match_a_separate_run():
    """Measuring 3 samples alone gives the same values as measuring 1, 3 and 5 together."""
    ways = {name: integrands.of_library(name) for name in ("white", "sobol", "zorder", "blue")}
    rows = samplers.measure_all(ways, 1, (1, 3, 5), integrands.images_at_every_count)
    found = {(row["row"], row["sampler"], row["spp"]): float(row["value"]) for row in rows}
    assert all(found["half-planes", "blue", spp] < 0.8 < found["half-planes", "white", spp] for spp in (1, 3, 5))
    alone = samplers.measure_all(ways, 1, (3,), integrands.images_at_every_count)
    assert {(row["sampler"], row["value"]) for row in alone if row["row"] == "half-planes"} == {
        (row["sampler"], row["value"]) for row in rows if row["row"] == "half-planes" and row["spp"] == 3}


def test_samplers_with_counts_of_their_own_have_values_only_there(monkeypatch):
    monkeypatch.setitem(samplers.ONLY, "blue", (4, 9))
    rows = samplers.measure_all({name: integrands.of_library(name) for name in ("sobol", "blue")}, 1, (1, 4), integrands.images_at_every_count)
    assert {row["spp"] for row in rows if row["sampler"] == "blue"} == {4} and {row["spp"] for row in rows if row["sampler"] == "sobol"} == {1, 4}
    values = [{**row, "value": float(row["value"])} for row in rows]
    assert samplers.row_table(values, "half-planes", (1, 4)).splitlines()[-1].startswith("| `blue` |  | 0.")


def test_peers_draw_distinct_uniform_numbers(pathtracer):
    drawn = []
    for name in variants.PEERS if (plugins.FOLDER / "openqmc.so").is_file() else ():
        draw = plugins.load(f"{plugins.FOLDER}/openqmc.so:{name.partition('-')[2]}").way(64)
        numbers = [draw(1, 2, member) for member in range(4)]
        assert np.shape(numbers) == (4, 64, 64, 2, 4)
        np.testing.assert_allclose(np.mean(numbers, (1, 2, 3)), 0.5, atol=0.02)
        drawn += [each.tobytes() for each in numbers]
    assert len(set(drawn)) == len(drawn)


def test_wins_list_only_clear_leads():
    rows = [{"row": "half-planes", "sampler": name, "spp": 4, "value": value} for name, value in (("blue", 0.8), ("zorder", 0.6), ("mask", 0.77))]
    assert samplers.wins_table(rows).splitlines()[2:] == ["| half-planes, sigma 2.1 | Z-order, tuned for N | 25% at 4 |"]


# ---- Tables of Heitz et al.

def test_tables_are_read_from_c_and_rust_sources(tmp_path):
    random = np.random.default_rng(4)
    tables = {kind: random.integers(0, 256, size, np.uint8) for kind, size in heitz.SIZES.items()}
    numbers = {kind: ",\n".join(map(str, table)) for kind, table in tables.items()}
    (tmp_path / "x_128x128_OptimizedFor_2d2d2d2d_4spp.cpp").write_text("// 4spp\n" + "".join(
        f"static const int {name}[{size}] = {{{numbers[kind]}}};\n" for kind, name, size in (
            ("sobol", "sobol_256spp_256d", "256*256"), ("scrambling", "scramblingTile", "128*128*8"), ("ranking", "rankingTile", "128*128*8"))))
    (tmp_path / "spp1.rs").write_text("".join(f"pub static {kind.upper()}_TILE: &'static [i32] = &[\n{numbers[kind]},\n];\n" for kind in ("sobol", "scrambling")))
    found = heitz.Tables(tmp_path)
    assert [found.for_count(n) for n in (1, 2, 3, 4, 5)] == [1, 4, 4, 4, 4]
    assert all(np.array_equal(found.read(4)[kind], table) for kind, table in tables.items()) and not found.read(1)["ranking"].any()
    assert (found.write(tmp_path) / "4.bin").read_bytes() == b"".join(table.tobytes() for table in tables.values())
    u = found.numbers(*np.meshgrid(range(8), range(6)), range(4), 8, 4)
    assert u.shape == (6, 8, 4, 8) and u.dtype == np.float32 and 0 < u.min() and u.max() < 1
    (tmp_path / "spp2.rs").write_text("none")
    with pytest.raises(CommandError, match="does not contain"):
        heitz.Tables(tmp_path).read(2)
    (tmp_path / "empty").mkdir()
    with pytest.raises(CommandError, match="_16spp"):
        heitz.Tables(tmp_path / "empty")
