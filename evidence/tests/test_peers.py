# SPDX-License-Identifier: Apache-2.0
"""The plug-ins for comparison: nets, lattices, and samplers that read tables."""

import itertools
import math

import numpy as np
import pytest

from evidence.base.command import CommandError
from evidence.samplers import heitz, plugins

pytestmark = pytest.mark.skipif(not plugins.PROGRAM.is_file(), reason="the plug-ins are not built; run scripts/setup")


def points(name, decision, first, count, dimensions=4, seed=7, **more):
    """[samples][dimensions] of pixel (-300, 99)."""
    return plugins.load(plugins.FOLDER / name).numbers(seed, 1, first, count, decision, dimensions, **{"x0": -300, "y0": 99, **more})[0, 0]


def is_even(u, *sides):
    """Whether each box of a grid that divides the dimensions into `sides` parts holds the same number of points, which are truncated to 24 bits."""
    cells = np.ravel_multi_index([((own + 2**-25) * side).astype(int) for own, side in zip(u.T.astype(float), sides)], sides)
    return len(set(np.bincount(cells, minlength=math.prod(sides)))) == 1


def is_net(u, base, t=0):
    """Whether base^m points are a (t, m, s)-net: even in every grid of base^(m - t) boxes."""
    digits = max(round(math.log(len(u), base)) - t, 0)
    return all(is_even(u, *(base**share for share in shares))
               for shares in itertools.product(range(digits + 1), repeat=u.shape[1]) if sum(shares) == digits)


@pytest.mark.skipif(not (plugins.FOLDER / "sobol_global.so").is_file(), reason="built without Boost")
@pytest.mark.parametrize("corner", [(0, 0), (-8, 640), (5000, -16)])
def test_screen_is_a_net_of_global_sobol(corner):
    """In an aligned block of 8 x 8 pixels, the screen positions and times of four samples form a net."""
    plugin = plugins.load(plugins.FOLDER / "sobol_global.so")
    for seed in range(3):
        position, other = (plugin.numbers(seed, 8, 4, 4, decision, 4, 0, *corner) for decision in (0, 12))
        y, x = np.mgrid[:8, :8]
        screen = np.stack([(x[..., None] + position[..., 0]) / 8, (y[..., None] + position[..., 1]) / 8, other[..., 2], other[..., 3]], -1).reshape(256, 4)
        assert is_net(screen[:, :2], 2) and is_net(screen[:, :3], 2, 1) and is_net(screen, 2, 3)
        assert is_net(points("sobol_global.so", 0, 0, 256, 2, seed), 2)


def test_consecutive_dimensions_of_cascaded_sobol_are_nets_for_the_declared_count(tmp_path):
    """Any table will do."""
    (tmp_path / "table").write_text("".join(f"{d} {'1 0 1' if d % 2 else '2 1 1 3'}\n" for d in range(1, 17)))
    for samples, decision in itertools.product((4, 16, 64), (0, 4)):
        assert is_net(points(f"cascaded_sobol.so:{tmp_path}/table", decision, 0, samples, 2, samples=samples), 2), (samples, decision)


@pytest.mark.parametrize("line", ["17 0 1 1", "17 32 1 1", "seventeen", "17 2 1 1"])
def test_bad_lines_of_a_table_are_rejected(line, tmp_path, capfd):
    """They would shift the dimensions after them."""
    (tmp_path / "table").write_text("d s a m_i\n" + "1 1 0 1\n" * 16 + line + "\n18 1 0 1\n")
    with pytest.raises(CommandError):
        points(f"cascaded_sobol.so:{tmp_path}/table", 0, 0, 4)
    assert "rejects the argument" in capfd.readouterr().err


def test_pairs_and_quadruples_of_quad_optimized_sequences_are_nets(tmp_path):
    """Degrees of 1 and 2 bound t by 1 in the quadruples. Decisions 2, 6, 10 ... have a pair."""
    (tmp_path / "table").write_text("1 1 3 1\n2 1 4 1\n3 1 5 1\n4 2 14 1 1\n" * 12)
    name = f"quad_optimized.so:{tmp_path}/table"
    for m, decision in itertools.product(range(1, 7), (0, 12, 28, 30)):
        u = points(name, decision, 2 * 3**m, 3**m)
        assert is_net(u[:, :2], 3), (m, decision)
        assert decision == 30 or (is_net(u[:, 2:], 3) and is_net(u, 3, 1)), (m, decision)
    # The scrambling is nested and differs between pixels: the order within a third says nothing about the next.
    u = plugins.load(plugins.FOLDER / name).numbers(7, 8, 0, 5, 0, 2)[..., 0]
    assert 16 < np.sum((u[..., 0] < u[..., 3]) == (u[..., 1] < u[..., 4])) < 48


@pytest.mark.parametrize("seed", range(3))
def test_halton_is_stratified_in_powers_of_its_primes(seed):
    for decision, sides in ((0, (8, 9)), (0, (16, 3)), (4, (23, 29))):
        assert is_even(points("halton.so", decision, 0, math.prod(sides), 2, seed), *sides)
    assert not np.array_equal(*(points("halton.so", 0, 2, 1, seed=own) for own in (seed, seed + 3)))


@pytest.mark.parametrize("count", [1, 2, 8, 64])
def test_lattice_is_equally_spaced_in_each_dimension(count):
    u = points("lattice.so", 0, 0, count)
    assert all(len(set(column)) == count for column in (np.rint((u - u[0]) * count).astype(int) % count).T)


def test_slices_are_tiled_and_each_pair_has_its_own_offset(tmp_path):
    pairs, path = np.arange(2 * 3 * 4 * 2, dtype=np.float32).reshape(2, 3, 4, 2) / 64, tmp_path / "slices"
    path.write_bytes(np.array(pairs.shape[:3], np.uint32).tobytes() + pairs.tobytes())
    u = plugins.load(f"{plugins.FOLDER}/slices.so:{path}").numbers(3, 24, 0, 6, 0, 4, 0, -9, -7)
    tile = u[:3, :4]
    assert np.array_equal(u, np.tile(tile, (8, 6, 1, 1))) and np.array_equal(u[:, :, 1], u[:, :, 5])
    for i, pair in itertools.product((0, 1), (slice(0, 2), slice(2, 4))):
        assert sorted(map(tuple, tile[:, :, i, pair].reshape(12, 2))) == sorted(map(tuple, pairs[i].reshape(12, 2)))
    assert not np.array_equal(tile[..., :2], tile[..., 2:])
    path.write_bytes(path.read_bytes()[:-4])
    with pytest.raises(CommandError):
        points(f"slices.so:{path}", 0, 0, 1)


def test_heitz_reads_the_tables_of_the_next_count_or_the_largest(tmp_path):
    """The same tile entries everywhere, so that seeds, which shift it, do not matter."""
    for spp in (4, 16):
        tables = {"SOBOL": np.random.default_rng(spp).integers(0, 256, 65536), "SCRAMBLING": np.full(131072, 3), "RANKING": np.full(131072, 1)}
        (tmp_path / f"spp{spp}.rs").write_text("".join(f"{kind}: &[{','.join(map(str, table))}];\n" for kind, table in tables.items()))
    tables = heitz.Tables(tmp_path)
    for samples, spp in ((1, 4), (4, 4), (5, 16), (99, 16), (0, 16)):
        u = np.concatenate([points(f"heitz.so:{tables.write(tmp_path)}", decision, 0, 8, samples=samples) for decision in (0, 4)], 1)
        np.testing.assert_array_equal(u, tables.numbers(0, 0, range(8), 8, spp))
