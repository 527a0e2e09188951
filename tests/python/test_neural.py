# SPDX-License-Identifier: Apache-2.0
"""Runs networks in the real ONNX Runtime: a convolution, which NumPy repeats; the built-in networks; and invalid input."""

import os
import pickle
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers import assert_interrupted, needs_network, needs_package, needs_runtime, refused, run_python
from onnx_file import convolution

import bluenoise
from bluenoise import NeuralGenerator, RuntimeMissingError, _neural

pytestmark = [needs_network, needs_runtime]

RADIUS = 2
KERNELS = np.random.default_rng(1).normal(0.02, 0.1, (2, 5, 5)).astype(np.float32)
KERNELS[:, 2, 2] = 0.5
ONE = convolution(KERNELS[:1])
TWO = convolution(KERNELS)


def convolve(noise, kernel):
    """The valid part of a cross-correlation, in double precision."""
    windows = np.lib.stride_tricks.sliding_window_view(noise, kernel.shape)
    return np.einsum("yxij,ij->yx", windows, kernel.astype(float))


@pytest.fixture(scope="module")
def one():
    return NeuralGenerator(ONE)


@pytest.fixture(scope="module")
def builtin():
    try:
        return NeuralGenerator()
    except ValueError as error:
        pytest.skip(f"no network in this build: {error}")


def test_window_matches_a_numpy_convolution(one):
    noise = NeuralGenerator.noise(-5 - RADIUS, 7 - RADIUS, 300 + 2 * RADIUS, 40 + 2 * RADIUS, seed=3)
    expected = np.clip(convolve(noise, KERNELS[0]), 0, 1 - 2**-24)
    found = one.window(-5, 7, 300, 40, seed=3)
    assert found.shape == (40, 300) and found.dtype == np.float32
    np.testing.assert_allclose(found, expected, atol=1e-6)
    two = NeuralGenerator(TWO)
    assert (one.channels, two.channels) == (1, 2)
    second = np.clip(convolve(noise, KERNELS[1]), 0, 1 - 2**-24)
    np.testing.assert_allclose(two.window(-5, 7, 300, 40, seed=3), [expected, second], atol=1e-6)


def test_quantiles_make_windows_uniform(one):
    values = convolve(NeuralGenerator.noise(-RADIUS, -RADIUS, 400 + 2 * RADIUS, 300 + 2 * RADIUS, seed=8), KERNELS[0])
    quantiles = np.rint(2.0**24 * np.quantile(values, np.arange(65) / 64)).astype(int)
    uniform = NeuralGenerator(convolution(KERNELS[:1], quantiles=",".join(map(str, quantiles))))
    found = uniform.window(0, 0, 400, 300, seed=8)
    np.testing.assert_allclose(found, np.interp(values, quantiles / 2.0**24, np.arange(65) / 64), atol=1e-5)
    assert found.max() < 1 and np.ptp(np.histogram(found, bins=64, range=(0, 1))[0]) <= 4
    assert (uniform.mask((50, 40), seed=8) == one.mask((50, 40), seed=8)).all()


def test_seeds_threads_and_paths(one, tmp_path):
    path = tmp_path / "model.onnx"
    path.write_bytes(ONE)
    expected = one.mask((70, 300), seed=2**64 - 1)
    copy = pickle.loads(pickle.dumps(NeuralGenerator(path)))
    assert "model.onnx" in repr(copy)
    others = NeuralGenerator(path, threads=1), NeuralGenerator(str(path), threads=3), NeuralGenerator(bytearray(ONE)), copy
    for other in others:
        assert (other.mask((70, 300), seed=2**64 - 1) == expected).all()
    assert (one.mask((70, 300), seed=0) != expected).any()
    generator = np.random.default_rng(5), np.random.default_rng(5)
    assert (one.mask((20, 20), seed=generator[0]) == one.mask((20, 20), seed=generator[1])).all()
    assert (bluenoise.neural((70, 300), seed=2**64 - 1, model=path) == expected).all()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems reject such names")
def test_file_names_that_are_not_unicode(one, tmp_path, monkeypatch):
    folder = tmp_path / os.fsdecode(b"\xff\xe9t\xe9")
    folder.mkdir()
    path, broken = folder / "m.onnx", folder / "broken.onnx"
    path.write_bytes(ONE)
    broken.write_bytes(b"nothing")
    runtime = os.path.realpath(_neural._installed_runtime() or os.environ["BN_ONNXRUNTIME"])
    (folder / "runtime.so").symlink_to(runtime)
    for arguments in ({"model": path}, {"model": path, "runtime": folder / "runtime.so"}):
        assert (NeuralGenerator(**arguments).mask((20, 30)) == one.mask((20, 30))).all()
    with pytest.raises(ValueError, match=r"model: .*\\udcff\\udce9t\\udce9/broken\.onnx"):
        NeuralGenerator(broken)
    monkeypatch.setattr(_neural, "_installed_runtime", lambda: None)
    with pytest.raises(RuntimeMissingError, match="pip install"):
        NeuralGenerator(path, runtime=broken)


def test_providers(one, capfd):
    """The default provider is the CPU. On a GPU, values differ only by rounding; without a GPU, an error is raised."""
    expected = one.window(3, 4, 300, 200, seed=5)
    same = NeuralGenerator(ONE, provider="cpu")
    assert "provider='cpu'" in repr(same) and repr(pickle.loads(pickle.dumps(same))) == repr(same)
    assert (same.window(3, 4, 300, 200, seed=5) == expected).all()
    assert (bluenoise.neural((20, 30), model=ONE, provider="cpu") == one.mask((20, 30))).all()
    try:
        found = NeuralGenerator(ONE, provider="cuda")
    except RuntimeMissingError as error:
        assert "'cuda'" in str(error) and "onnxruntime-gpu" in str(error)
        with pytest.raises(RuntimeMissingError):
            bluenoise.neural((20, 30), model=ONE, provider="cuda")
    else:
        assert (Path(_neural._installed_runtime() or os.environ["BN_ONNXRUNTIME"]).parent
                / "libonnxruntime_providers_cuda.so").exists()
        np.testing.assert_allclose(found.window(3, 4, 300, 200, seed=5), expected, atol=1e-5)
    assert capfd.readouterr() == ("", "")


def test_builtin_vector_network(builtin):
    """tests/trainer checks the energy of its masks."""
    vectors = NeuralGenerator(channels=2)
    assert (builtin.channels, vectors.channels) == (1, 2)
    assert "channels=2" in repr(vectors) and pickle.loads(pickle.dumps(vectors)).channels == 2
    ranks = vectors.mask((96, 64), seed=4)
    assert ranks.shape == (2, 96, 64)
    for channel in ranks:
        assert np.array_equal(np.sort(channel, axis=None), np.arange(96 * 64))
        assert bluenoise.dithering_error(channel) < 0.06  # white noise has .115
    window = vectors.window(-7, 9, 50, 40, seed=4)
    assert window.shape == (2, 40, 50)
    np.testing.assert_allclose(vectors.window(3, 19, 20, 10, seed=4), window[:, 10:20, 10:30], atol=1e-5)
    assert (bluenoise.neural((96, 64), channels=2, seed=4) == ranks).all()


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda g: g.mask((16,)), ValueError, ["shape", "(16,)"]),
        (lambda g: g.mask((0, 4)), ValueError, ["shape", "0"]),
        (lambda g: g.mask((2**20, 2**20)), MemoryError, ["1048576"]),
        (lambda g: g.mask((4, 4), seed=-1), ValueError, ["seed", "-1"]),
        (lambda g: g.window(0, 0, 0, 4), ValueError, ["width", "0"]),
        (lambda g: g.window(0, 0, 4, -1), ValueError, ["height", "-1"]),
        (lambda g: g.window(0.5, 0, 4, 4), TypeError, ["x0", "0.5"]),
        (lambda g: g.window(2**40, 0, 4, 4), ValueError, ["x0", str(2**40)]),
        (lambda g: g.window(0, -(2**40) - 1, 4, 4), ValueError, ["y0", str(-(2**40) - 1)]),
        (lambda g: g.window(0, 0, 2**20, 2**20), MemoryError, ["1048576"]),
        (lambda g: NeuralGenerator(ONE, threads=-1), ValueError, ["threads", "-1"]),
        (lambda g: NeuralGenerator(ONE, provider="gpu"), ValueError, ["provider", "cpu, cuda", "'gpu'"]),
        (lambda g: NeuralGenerator(ONE, provider=0), TypeError, ["provider", "0"]),
        (lambda g: NeuralGenerator(channels=3), ValueError, ["channels", "3"]),
        (lambda g: NeuralGenerator(ONE, channels=2), ValueError, ["channels: 2"]),
        (lambda g: NeuralGenerator(7), TypeError, ["model", "7"]),
        (lambda g: NeuralGenerator(""), ValueError, ["model"]),
        (lambda g: NeuralGenerator(b""), ValueError, ["model"]),
        (lambda g: NeuralGenerator(ONE[:-9]), ValueError, ["bad data", f"{len(ONE) - 9} bytes"]),
        (lambda g: NeuralGenerator(Path("nowhere.onnx")), FileNotFoundError, ["nowhere.onnx"]),
        (lambda g: NeuralGenerator(Path(__file__)), ValueError, ["test_neural.py"]),
        (lambda g: NeuralGenerator(Path(__file__).parent), OSError, ["model"]),
        (lambda g: NeuralGenerator(ONE, runtime="nowhere.so"), RuntimeMissingError, ["nowhere.so", "pip install"]),
        (lambda g: NeuralGenerator(ONE, runtime=__file__), RuntimeMissingError, ["test_neural.py"]),
        (lambda g: bluenoise.neural((4, 4, 4)), ValueError, ["shape", "(4, 4, 4)"]),
        (lambda g: bluenoise.neural((4, 4), sigma=1), TypeError, ["sigma"]),
    ],
)
def test_bad_arguments(one, call, error, words, capfd):
    with refused(error, words):
        call(one)
    assert capfd.readouterr() == ("", "")


def test_signals_interrupt_large_masks_and_windows():
    """Signal handlers run while the network runs, so signals during one call are handled separately and Ctrl-C stops it. If handlers ran
    only after the call, all signals would be handled together."""
    large = NeuralGenerator(ONE, threads=1)
    assert_interrupted(lambda: large.mask((6000, 6000)), signals=3)
    assert_interrupted(lambda: large.window(0, 0, 6000, 6000), signals=3)
    assert large.mask((16, 16)).shape == (16, 16)


def test_out(one):
    two = NeuralGenerator(TWO)
    for generator, shape in ((one, (30, 40)), (two, (2, 30, 40))):
        ranks, values = np.zeros(shape, np.uint32), np.zeros(shape, np.float32)
        assert generator.mask((30, 40), seed=3, out=ranks) is ranks
        assert (ranks == generator.mask((30, 40), seed=3)).all()
        assert generator.window(5, 6, 40, 30, out=values) is values
        assert (values == generator.window(5, 6, 40, 30)).all()
    for out in (np.zeros((30, 40)), np.zeros((40, 30), np.float32), np.zeros((2, 30, 40), np.float32)):
        with pytest.raises(ValueError, match="^out must"):
            one.window(0, 0, 40, 30, out=out)


@pytest.mark.parametrize("name", ["model", "runtime", "BN_ONNXRUNTIME"])
def test_pipes_are_rejected_immediately(name, tmp_path):
    """Opening a pipe would wait for a writer forever, and Ctrl-C could not interrupt the wait."""
    os.mkfifo(tmp_path / "pipe")
    program = f"import bluenoise; bluenoise.NeuralGenerator({name}={str(tmp_path / 'pipe')!r})"
    environment = dict(os.environ)
    if name == "BN_ONNXRUNTIME":
        program, environment[name] = "import bluenoise; bluenoise.NeuralGenerator()", str(tmp_path / "pipe")
    last = run_python(program, env=environment).stderr.splitlines()[-1]
    assert "regular file" in last and str(tmp_path / "pipe") in last


def test_error_in_a_build_without_networks(monkeypatch):
    monkeypatch.delattr(bluenoise._core, "NeuralGenerator")
    _neural.builtin_generator.cache_clear()
    for call in (NeuralGenerator, lambda: NeuralGenerator.noise(0, 0, 1, 1), lambda: bluenoise.neural((16, 16))):
        with pytest.raises(RuntimeMissingError, match="BN_NEURAL=OFF"):
            call()


def test_missing_runtime_error_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(_neural, "_installed_runtime", lambda: None)
    monkeypatch.setenv("BN_ONNXRUNTIME", str(tmp_path / "nowhere.so"))
    with pytest.raises(RuntimeMissingError, match="pip install 'onnxruntime>=1.19'"):
        NeuralGenerator(ONE)


@needs_package
def test_runtime_is_found_in_the_installed_package(monkeypatch):
    monkeypatch.delenv("BN_ONNXRUNTIME", raising=False)
    path = _neural._installed_runtime()
    assert path is not None and Path(path).is_file() and "onnxruntime" in Path(path).name
    assert NeuralGenerator(ONE, runtime=Path(path)).mask((16, 16)).shape == (16, 16)
    monkeypatch.setenv("BN_ONNXRUNTIME", path)
    assert _neural._installed_runtime() is None
    assert NeuralGenerator(ONE).mask((16, 16)).shape == (16, 16)


def in_onnxruntime(folder, model, noise):
    """Runs the model on the noise with the onnxruntime package in a separate process. Returns an array (channels, height, width)."""
    program = (
        "import sys, numpy as np, onnxruntime\n"
        "session = onnxruntime.InferenceSession(sys.stdin.buffer.read())\n"
        "noise = np.load(sys.argv[1])[None, None]\n"
        "np.save(sys.argv[2], session.run(None, {'noise': noise})[0][0])\n"
    )
    paths = [str(folder / name) for name in ("noise.npy", "out.npy")]
    np.save(paths[0], noise)
    environment = {**os.environ, "ORT_DISABLE_TELEMETRY": "1"}
    subprocess.run([sys.executable, "-c", program, *paths], input=model, check=True, env=environment)
    return np.load(paths[1])


@needs_package
@pytest.mark.parametrize("name", ["neural.onnx", "neural_fast.onnx", "neural_vector.onnx"])
@pytest.mark.parametrize("shape", [(64, 64), (52, 132)])
def test_builtin_networks_match_onnxruntime(tmp_path, name, shape):
    """Ranks are ordered by the network's values, except for the first and last ranks, which libbn reorders."""
    model = (Path(__file__).resolve().parents[2] / "libbn/data" / name).read_bytes()
    radius = int(re.search(rb"bn\.receptive_radius\x12.(\d+)", model)[1])
    noise = np.pad(NeuralGenerator.noise(0, 0, shape[1], shape[0], seed=9), radius, mode="wrap")
    channels = in_onnxruntime(tmp_path, model, noise)
    masks = NeuralGenerator(model).mask(shape, seed=9).reshape(-1, *shape)
    assert len(channels) == len(masks) == (2 if "vector" in name else 1)
    for values, ranks in zip(channels, masks):
        in_order = values.ravel()[np.argsort(ranks.ravel())]
        # libbn reorders the ranks whose points are at least 3.5 texels apart on average.
        points = 0 if "vector" in name else int(values.size / 3.5**2)
        for end in (in_order[:points], in_order[values.size - points :]):
            assert points == 0 or (np.diff(end) < -1e-3).any()
            end.sort()
        assert values.std() > 0.2 and (np.diff(in_order) > -1e-4).all()


def test_builtin_windows_are_consistent_and_uniform(builtin):
    plane = builtin.window(-300, 20, 500, 400, seed=6)
    assert plane.min() >= 0 and plane.max() < 1
    # For 200,000 texels of white noise, the deviation exceeds .002 with a probability of about 10^-4.
    counts = np.histogram(plane, bins=64, range=(0, 1))[0] / plane.size
    assert abs(np.cumsum(counts) - np.arange(1, 65) / 64).max() < 0.01
    for x0, y0 in ((-300, 20), (-157, 91), (-42, 300)):
        part = builtin.window(x0, y0, 150, 101, seed=6)
        np.testing.assert_allclose(part, plane[y0 - 20 : y0 + 81, x0 + 300 : x0 + 450], atol=1e-5)
    far = builtin.window(2**40 - 64, -(2**40), 64, 64, seed=6)
    assert 0.4 < far.mean() < 0.6


@needs_package
@pytest.mark.parametrize("model", [None, ONE])
def test_masks_page_listing(model):
    page = (Path(__file__).resolve().parents[2] / "docs/masks.md").read_text(encoding="utf-8")
    (listing,) = (text for text in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "neural(" in text)
    y, x = np.mgrid[:64, :64]
    space = {"bluenoise": bluenoise, "model": model, "x": x, "y": y}
    exec(listing, space)
    first = space["u"][..., 0]
    assert (np.argsort(first, axis=None, kind="stable") != np.arange(4096)).any()
    # Each pixel's first number is its rank, scrambled with a key that all pixels share.
    assert len(np.unique((first * 4096).astype(int))) == 4096
