# SPDX-License-Identifier: Apache-2.0
"""Neural mask generation, and the search for ONNX Runtime, which runs the networks."""

from __future__ import annotations

import functools
import importlib.util
import math
import os
from pathlib import Path
from typing import Any, Optional, Union, get_args

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import NeuralProvider, Progress, Ranks, Seed, Shape

PathLike = Union[str, "os.PathLike[str]"]

_FARTHEST = 2**40
_MASK_MEMORY = 30  # bytes per texel and channel, measured
# Older packages do not include the library.
_MISSING = {
    "cpu": "neural masks need ONNX Runtime: pip install 'onnxruntime>=1.19'",
    "cuda": "provider 'cuda' needs an NVIDIA GPU, CUDA, cuDNN and ONNX Runtime for them: pip install 'onnxruntime-gpu>=1.19'",
}


class NeuralGenerator:
    """A network that turns white noise into seamless blue noise of any size in one pass. Based on Giunchi, Sztrajman and Steed,
    "Fast Blue-Noise Generation via Unsupervised Learning", 2022.

    The network runs in ONNX Runtime, which is loaded from the first of these places that exists: ``runtime``, the path in the
    ``BN_ONNXRUNTIME`` environment variable, the installed ``onnxruntime`` package, or the system. Quality does not depend on the
    seed. The exact bits may depend on the version of ONNX Runtime. Generators are immutable and thread-safe, and can be pickled.

    Parameters
    ----------
    model : path-like or bytes, optional
        The path to an ONNX file, or the file's contents as bytes, in the format documented at ``bn_neural_open`` in
        ``bn/neural.h``. Defaults to the built-in network.
    runtime : path-like, optional
        The path to the ONNX Runtime library (``libonnxruntime.so``). By default, the library is searched for as described above.
    threads : int, default 0
        The number of threads per call; 0 means one per CPU that the process may use, or at most four if a GPU runs the network.
        The thread count does not affect the results.
    provider : {"cpu", "cuda"}, optional
        The device that runs the network: ``"cpu"`` (the default) or ``"cuda"``, an NVIDIA GPU. ``"cuda"`` needs the
        ``onnxruntime-gpu`` package instead of ``onnxruntime``, and the versions of CUDA and cuDNN it was built for. The generator
        never falls back to the CPU.
    channels : int, default 0
        The number of channels. For the built-in network: 1 (or 0, the default), or 2 for vector masks, whose channels are jointly
        blue (see `bluenoise.mask`). For your own model: 0, or the number of channels the model must have.

    Raises
    ------
    RuntimeMissingError
        No usable ONNX Runtime was found, it lacks the provider or finds no GPU, or bluenoise was built without the network
        (``BN_NEURAL=OFF``).
    FileNotFoundError, OSError
        The model cannot be read.
    ValueError
        The model is not a suitable network, or does not have ``channels`` channels.

    Notes
    -----
    Opening a network takes up to a few tenths of a second, so reuse the generator. Ctrl-C interrupts `mask` and `window`.
    """

    __slots__ = ("_arguments", "_core")

    _arguments: tuple[Union[None, str, bytes], Optional[str], int, Optional[str], int]
    _core: _core.NeuralGenerator

    def __init__(
        self,
        model: Union[None, PathLike, bytes] = None,
        runtime: Optional[PathLike] = None,
        threads: int = 0,
        provider: Optional[NeuralProvider] = None,
        channels: int = 0,
    ) -> None:
        _check_build()
        count = arguments.integer("threads", threads, *arguments.UINT32)
        wanted = arguments.integer("channels", channels, 0, 2 if model is None else 16)
        library = None if runtime is None else _path("runtime", runtime)
        if provider is not None:
            arguments.one_of("provider", provider, get_args(NeuralProvider))
        content = bytes(model) if isinstance(model, (bytes, bytearray, memoryview)) else None
        path = None if model is None or content is not None else _path("model", model)
        if path is not None and not os.path.exists(path):
            raise FileNotFoundError(f"model {path} does not exist")
        if library is not None and os.sep in library and not os.path.exists(library):
            raise FileNotFoundError(f"runtime {library} does not exist")
        if path is not None and not os.path.isfile(path):  # a pipe could keep the caller waiting for ever
            raise OSError(f"model {path} is not a regular file")
        if content == b"":
            raise ValueError("model must not be empty, but is b''")
        said = "built in" if model is None else f"{len(content)} bytes" if content is not None else path
        named = library or os.environ.get("BN_ONNXRUNTIME")
        if named and os.path.exists(named) and not os.path.isfile(named):
            raise _core.RuntimeMissingError(f"runtime {named} is not a regular file")
        found = library or _installed_runtime()
        where = f"model: {said}, runtime: {found or 'from the system'}" + (f", channels: {wanted}" if wanted else "")
        try:
            generator = _core.NeuralGenerator(
                None if path is None else os.fsencode(path),
                content,
                None if found is None else os.fsencode(found),
                count,
                provider,
                wanted,
                where.encode(errors="backslashreplace").decode(),  # a file name may not be valid Unicode
            )
        except _core.RuntimeMissingError as error:
            raise _core.RuntimeMissingError(f"{error}; {_MISSING[provider or 'cpu']}") from None
        put = object.__setattr__
        put(self, "_arguments", (path or content, library, count, provider, wanted))
        put(self, "_core", generator)

    @property
    def channels(self) -> int:
        """The number of output channels. With more than one, results have shape (channels, h, w)."""
        return self._core.channels

    def mask(
        self, shape: Shape, seed: Seed = 0, *, out: Optional[Ranks] = None, progress: Optional[Progress] = None
    ) -> Ranks:
        """Make a toroidal mask.

        Parameters
        ----------
        shape : tuple of int
            ``(height, width)``. Any size works; quality is guaranteed at 16 x 16 and above.
        seed : int, numpy.random.Generator, numpy.random.SeedSequence or None, default 0
            See `bluenoise.mask`.
        out : ndarray of uint32, optional
            A C-ordered array of the result's shape, which is filled and returned.
        progress : callable, optional
            See `bluenoise.mask`.

        Returns
        -------
        ndarray of uint32
            Ranks of shape ``(height, width)``, or ``(channels, height, width)``.
        """
        extents = arguments.shape(shape, 2)
        if len(extents) != 2:
            raise ValueError(f"shape of a neural mask must be (h, w), not {extents}")
        extents = self._shape(*extents)
        arguments.enough_memory(f"a neural mask of shape {extents}", math.prod(extents) * _MASK_MEMORY)
        ranks = arguments.output(out, extents, np.uint32)
        self._core.mask(ranks, arguments.seed(seed), arguments.callback("progress", progress))
        return ranks

    def window(
        self,
        x0: int,
        y0: int,
        width: int,
        height: int,
        seed: Seed = 0,
        *,
        out: Optional[npt.NDArray[np.float32]] = None,
    ) -> npt.NDArray[np.float32]:
        """Compute a window into an infinite plane of blue noise that never repeats.

        Parameters
        ----------
        x0, y0 : int
            Column and row of the top-left texel, from -2**40 to 2**40.
        width, height : int
            Extents in texels.
        seed : int, numpy.random.Generator, numpy.random.SeedSequence or None, default 0
            See `bluenoise.mask`.
        out : ndarray of float32, optional
            A C-ordered array of the result's shape, which is filled and returned.

        Returns
        -------
        ndarray of float32
            Values in [0, 1) of shape ``(height, width)``, or ``(channels, height, width)``. They are uniformly distributed over
            the plane. Overlapping windows with the same seed agree to within 1e-5.
        """
        x0, y0, width, height = _window(x0, y0, width, height, _FARTHEST)
        values = arguments.output(out, self._shape(height, width), np.float32)
        self._core.window(x0, y0, values, arguments.seed(seed))
        return values

    def _shape(self, height: int, width: int) -> tuple[int, ...]:
        return (height, width) if self.channels == 1 else (self.channels, height, width)

    @staticmethod
    def noise(
        x0: int, y0: int, width: int, height: int, seed: Seed = 0
    ) -> npt.NDArray[np.float32]:
        """Compute the white noise that windows are made from. It is bit-identical on every machine.

        Parameters
        ----------
        x0, y0 : int
            Column and row of the top-left texel, from -2**41 to 2**41.
        width, height : int
            Extents in texels.
        seed : int, numpy.random.Generator, numpy.random.SeedSequence or None, default 0
            See `bluenoise.mask`.

        Returns
        -------
        ndarray of float32
            Values in [0, 1) of shape ``(height, width)``. Use them to train networks or to run networks elsewhere.
        """
        _check_build()
        return _core.neural_noise(*_window(x0, y0, width, height, 2 * _FARTHEST), arguments.seed(seed))

    def __reduce__(self) -> Any:
        return NeuralGenerator, self._arguments

    def __repr__(self) -> str:
        model, *others = self._arguments
        parts = [] if model is None else [f"<{len(model)} bytes>" if isinstance(model, bytes) else repr(model)]
        parts += [f"{name}={value!r}" for name, value in zip(("runtime", "threads", "provider", "channels"), others) if value]
        return f"NeuralGenerator({', '.join(parts)})"


def _check_build() -> None:
    if not hasattr(_core, "NeuralGenerator"):
        raise _core.RuntimeMissingError("bluenoise was built without the network (BN_NEURAL=OFF)")


@functools.lru_cache(maxsize=2)
def builtin_generator(channels: int = 1) -> NeuralGenerator:
    """A shared generator that uses the built-in network with this number of channels, and all threads."""
    return NeuralGenerator(channels=channels)


def _window(x0: int, y0: int, width: int, height: int, farthest: int) -> tuple[int, int, int, int]:
    width = arguments.integer("width", width, 1, arguments.UINT32[1])
    height = arguments.integer("height", height, 1, arguments.UINT32[1])
    x0 = arguments.integer("x0", x0, -farthest, farthest - width)
    y0 = arguments.integer("y0", y0, -farthest, farthest - height)
    if width * height > arguments.MAX_TEXELS:
        raise MemoryError(f"a window of {width} x {height} has more than 2**31 - 1 texels")
    return x0, y0, width, height


def _path(name: str, value: object) -> str:
    try:
        path = os.fspath(value)  # type: ignore[call-overload]
    except TypeError:
        raise TypeError(f"{name} must be a path, not {arguments.said(value)}") from None
    if not isinstance(path, str) or not path or "\0" in path:
        raise ValueError(f"{name} must be a path, not {path!r}")
    return path


def _installed_runtime() -> Optional[str]:
    """The path to the library in the installed onnxruntime package, found without importing it. None if it is not installed, or if
    BN_ONNXRUNTIME is set."""
    if os.environ.get("BN_ONNXRUNTIME"):
        return None
    try:
        spec = importlib.util.find_spec("onnxruntime")
    except (ImportError, ValueError):
        return None
    for folder in (spec.submodule_search_locations or ()) if spec is not None else ():
        for pattern in ("libonnxruntime.so*", "libonnxruntime.*dylib", "onnxruntime.dll"):
            libraries = sorted(Path(folder, "capi").glob(pattern))
            if libraries:
                return str(libraries[0])
    return None
