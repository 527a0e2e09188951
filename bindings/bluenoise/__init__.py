# SPDX-License-Identifier: Apache-2.0
"""Blue noise for path tracers and dithering: samples, masks and measures as NumPy arrays.

Arrays are indexed ``[y, x]``. A seed is an integer from 0 to 2**64 - 1, a ``numpy.random.Generator`` (which supplies one integer),
a ``numpy.random.SeedSequence``, or None for fresh entropy. The same seed gives bit-identical results on every machine, except for
neural masks and points. Functions raise ``ValueError`` for unknown names, numbers out of range, shapes that are wrong or do not
broadcast, and masks that are not permutations. They raise ``TypeError`` for undocumented argument types. They can also raise
``MemoryError``, ``OSError``, ``CancelledError`` and ``RuntimeMissingError``. Error messages include the argument's name and value.
All functions are thread-safe, except the methods of rays, loops and pans, which are stateful. Long computations release the GIL.
"""

from . import _subinterpreters

_subinterpreters.refuse()

from . import arrays
from ._arguments import NeuralProvider, PointsMethod, SamplerType
from ._choose import choose, choose_cdf, choose_u32
from ._core import CancelledError, RuntimeMissingError, __version__
from ._dither import dither
from ._files import load, save
from ._frames import Pan, frame_index, frame_stream
from ._masks import anneal, builtin, mask, neural, relax, to_float, void_and_cluster
from ._measure import MaskMeasures, anisotropy, dithering_error, measure, power_spectrum, radial_power
from ._neural import NeuralGenerator
from ._noise import visible_noise
from ._path import LoopSampler, PathSampler, RaySampler, Split
from ._points import points
from ._sampler import Sampler, domain, tables

__all__ = [
    "CancelledError",
    "MaskMeasures",
    "NeuralGenerator",
    "NeuralProvider",
    "Pan",
    "PathSampler",
    "PointsMethod",
    "RaySampler",
    "LoopSampler",
    "RuntimeMissingError",
    "Sampler",
    "SamplerType",
    "Split",
    "__version__",
    "anisotropy",
    "anneal",
    "arrays",
    "builtin",
    "choose",
    "choose_cdf",
    "choose_u32",
    "dither",
    "dithering_error",
    "domain",
    "frame_index",
    "frame_stream",
    "load",
    "mask",
    "measure",
    "neural",
    "points",
    "power_spectrum",
    "radial_power",
    "relax",
    "save",
    "tables",
    "to_float",
    "visible_noise",
    "void_and_cluster",
]
