# SPDX-License-Identifier: Apache-2.0
"""Mitsuba 3's multijittered and orthogonal samplers (the optional `mitsuba` package, BSD-3-Clause), with independent seeds in each pixel:
`scripts/bench samplers --sampler orthogonal=evidence/plugins/mitsuba_samplers.py:orthogonal`

Mitsuba rounds 32 multijittered samples up to 35, of which these are the first 32. Orthogonal arrays have squares of primes as sample counts."""

import functools

import mitsuba
import numpy as np

mitsuba.set_variant("scalar_rgb")


def drawn(kind, seed, x, y, index, decision, dimensions, samples):
    count, first = int(np.max(index)) + 1, decision // 2
    sampler = mitsuba.load_dict({"type": kind, "sample_count": max(samples, count)})
    pixels = np.stack(np.broadcast_arrays(*(np.asarray(v)[..., 0] for v in (x, y))), -1)
    own = int(np.random.default_rng([seed, 11]).integers(2**32))
    result = np.empty((*pixels.shape[:-1], count, dimensions), np.float32)
    for at in np.ndindex(pixels.shape[:-1]):
        sampler.seed((own + 65536 * int(pixels[at][1]) + int(pixels[at][0])) % 2**32)
        for i in range(count):
            pairs = [sampler.next_2d() for _ in range(first + 2)]  # for any number of dimensions, so that they agree
            result[(*at, i)] = np.ravel(pairs[first:])[:dimensions]
            sampler.advance()
    return np.minimum(result[..., np.ravel(index), :], np.float32(1 - 2**-24))


multijitter, orthogonal = functools.partial(drawn, "multijitter"), functools.partial(drawn, "orthogonal")
orthogonal.counts = (4, 9, 25, 49)
