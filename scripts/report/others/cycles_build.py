# SPDX-License-Identifier: Apache-2.0
"""Cycles' stand-alone program with the sampling pattern of examples/cycles. Kernels are for this processor alone, and what the scenes
do not need is left out."""

from pathlib import Path

from ..base.files import write_text
from ..renders.renderer import RenderError, cache_folder
from . import other_build
from .other_build import ROOT, git

OWN = ROOT / "examples" / "cycles"
PATCH = OWN / "cycles-v4.2.0.patch"
TAG, COMMIT = "v4.2.0", "6170e50fbd5fb8e36d71676e78c2693e58bf6c3d"
# What goes to src/kernel/sample.
SAMPLE = (OWN / "blue.h", ROOT / "libbn" / "include" / "bn" / "bn_draw.glsl", ROOT / "libbn" / "include" / "bn" / "bn_path.glsl")
OFF = ("ALEMBIC", "EMBREE", "OPENCOLORIO", "OPENIMAGEDENOISE", "OPENSUBDIV", "OPENVDB", "NANOVDB", "OSL", "USD", "DEVICE_CUDA",
       "DEVICE_OPTIX", "DEVICE_HIP", "HYDRA_RENDER_DELEGATE")
OPTIONS = ("-DCMAKE_BUILD_TYPE=Release", "-DWITH_CYCLES_NATIVE_ONLY=ON", *(f"-DWITH_CYCLES_{name}=OFF" for name in OFF))
# For measuring alone, (file, text, what it becomes). With the variable BN_COUNTS the program's one picture is the samples of each pixel,
# which adaptive sampling chooses; with BN_TOLD patterns are told that many samples, as a preview tells them, whatever is taken.
CHANGES = (
    ("src/app/cycles_standalone.cpp", "pass->set_type(PASS_COMBINED);",
     'pass->set_type(getenv("BN_COUNTS") ? PASS_SAMPLE_COUNT : PASS_COMBINED);'),
    ("src/session/session.cpp", "set_aa_samples(params.samples);",
     'set_aa_samples(getenv("BN_TOLD") ? atoi(getenv("BN_TOLD")) : params.samples);'),
)


def check(checkout):
    """Raises RenderError unless `checkout` is Cycles at TAG."""
    other_build.check(checkout, "Cycles", "src/kernel/sample/pattern.h", COMMIT,
                      f"git clone --branch {TAG} https://github.com/blender/cycles", f"git -C {checkout} checkout {TAG}")


def change(copy):
    for path, before, after in CHANGES:
        text = (copy / path).read_text(encoding="utf-8")
        if text.count(before) != 1:
            raise RenderError(f"{path} has no line {before}")
        write_text(copy / path, text.replace(before, after))


def prepare(checkout, folder):
    """Copies and patches the checkout, without its folders for precompiled libraries."""
    other_build.prepare(checkout, folder, PATCH, [COMMIT, git(checkout, "diff", "HEAD", "--", "src"),
                                                  *(word for words in CHANGES for word in words)],
                        [(path, "src/kernel/sample") for path in SAMPLE], ("lib",), change)


def build(checkout, jobs):
    """The path of Cycles with the pattern `blue`."""
    checkout = Path(checkout).resolve()
    check(checkout)
    folder = cache_folder() / "cycles"
    folder.mkdir(parents=True, exist_ok=True)
    prepare(checkout, folder)
    other_build.build(folder, jobs, "Cycles", OPTIONS, "cycles")
    return folder / "build" / "bin" / "cycles"
