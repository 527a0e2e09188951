# SPDX-License-Identifier: Apache-2.0
"""Mitsuba 3's multijittered sampler (the optional `mitsuba` package, BSD-3-Clause), with independent seeds in each pixel:
`scripts/bench samplers --sampler multijitter=evidence/plugins/mitsuba_samplers.py:multijitter`

Mitsuba rounds 32 samples up to 35, of which these are the first 32. Its orthogonal sampler only takes squares of primes."""

import mitsuba
import numpy as np

mitsuba.set_variant("scalar_rgb")


def multijitter(seed, x, y, index, decision, dimensions, samples):
    count, first = int(np.max(index)) + 1, decision // 2
    sampler = mitsuba.load_dict({"type": "multijitter", "sample_count": max(samples, count)})
    pixels = np.stack(np.broadcast_arrays(*(np.asarray(v)[..., 0] for v in (x, y))), -1)
    own = int(np.random.default_rng([seed, 11]).integers(2**32))
    result = np.empty((*pixels.shape[:-1], count, dimensions), np.float32)
    for at in np.ndindex(pixels.shape[:-1]):
        sampler.seed((own + 65536 * int(pixels[at][1]) + int(pixels[at][0])) % 2**32)
        for i in range(count):
            drawn = [sampler.next_2d() for _ in range(first + 2)]  # for any number of dimensions, so that they agree
            result[(*at, i)] = np.ravel(drawn[first:])[:dimensions]
            sampler.advance()
    return np.minimum(result[..., np.ravel(index), :], np.float32(1 - 2**-24))
