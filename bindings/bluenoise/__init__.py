# SPDX-License-Identifier: Apache-2.0
"""Blue noise for path tracers and dithering: samples, masks and measures as NumPy arrays.

Arrays are indexed ``[y, x]``. Seeds are integers from 0 to 2**64 - 1 or a ``numpy.random.Generator``, which then
gives one. The same seed gives the same bits on every machine, neural masks aside. Errors are ``ValueError``,
``TypeError``, ``MemoryError``, ``OSError`` and the two exceptions below; their text holds the name and the value of
the argument. All functions may be called from any number of threads; they work without Python's global lock.
"""

from ._core import CancelledError, RuntimeMissingError, __version__
from ._dither import dither
from ._masks import mask, to_float
from ._measure import anisotropy, measure, power_spectrum, radial_power
from ._neural import NeuralGenerator
from ._sampler import Sampler

__all__ = [
    "CancelledError",
    "NeuralGenerator",
    "RuntimeMissingError",
    "Sampler",
    "__version__",
    "anisotropy",
    "dither",
    "mask",
    "measure",
    "power_spectrum",
    "radial_power",
    "to_float",
]
