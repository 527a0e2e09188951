# SPDX-License-Identifier: Apache-2.0
"""The crates of examples/rust pass their own tests and draw the same paths as C."""

import os
import re
import shutil
import sys
from pathlib import Path

import pytest
from conftest import ROOT, VERSION, WINE, run

sys.path.append(str(ROOT / "tests" / "python"))
from hashes import hash_of, table  # noqa: E402

CRATES = ROOT / "examples" / "rust"

pytestmark = pytest.mark.skipif(shutil.which("cargo") is None, reason="Cargo is not installed")


@pytest.fixture(scope="module")
def cargo(amalgamation, tmp_path_factory):
    """Runs Cargo offline on a copy of the crates outside the checkout."""
    folder = tmp_path_factory.mktemp("rust")
    shutil.copytree(CRATES, folder / "crates", ignore=shutil.ignore_patterns("target"))
    environment = {**os.environ, "CARGO_TARGET_DIR": str(folder / "target"), "BN_AMALGAMATION": str(amalgamation)}

    def cargo(*arguments, **changes):
        return run("cargo", *arguments, "--offline", cwd=folder / "crates", env={**environment, **changes})

    cargo.crates, cargo.target = folder / "crates", folder / "target"
    return cargo


def test_crate_tests_pass(cargo):
    passed = re.findall(r"test result: ok\. (\d+) passed", cargo("test", "--quiet", "--locked", RUSTFLAGS="-D warnings"))
    assert sum(map(int, passed)) >= 8


def test_rust_draws_match_c(cargo):
    """The example prints a hash per path. As in tests/c/test_draw_hashes.c, these hashes are combined into one."""
    printed = cargo("run", "--quiet", "--example", "draws", RUSTFLAGS="-D warnings")
    assert hash_of([int(line.split()[-1], 16) for line in printed.splitlines()]) == table()["paths"]


def test_version_matches_the_library():
    for file in ("libbn/Cargo.toml", "libbn-sys/Cargo.toml", "Cargo.lock"):
        assert set(re.findall(r'^version = "(\S+)"$', (CRATES / file).read_text(), re.M)) == {VERSION}, file


def test_readme_program(cargo):
    (text,) = re.findall(r"^```rust\n(.*?)^```", (CRATES / "README.md").read_text(encoding="utf-8"), re.M | re.S)
    (cargo.crates / "libbn" / "examples" / "readme.rs").write_text(text)
    printed = cargo("run", "--quiet", "--example", "readme", RUSTFLAGS="-D warnings")
    assert len(printed.splitlines()) == 3


def test_error_for_a_folder_without_the_amalgamation(cargo, tmp_path):
    with pytest.raises(AssertionError, match=r"libbn-sys: no bn\.c in BN_AMALGAMATION="):
        cargo("build", "--locked", BN_AMALGAMATION=str(tmp_path), CARGO_TARGET_DIR=str(tmp_path / "target"))


def test_crate_builds_for_windows(cargo, windows):
    target, tools = "x86_64-pc-windows-gnu", "x86_64-w64-mingw32"
    standard_library = Path(run("rustc", "--print", "target-libdir", "--target", target).strip())
    if not standard_library.exists() or shutil.which(f"{tools}-gcc") is None:
        pytest.skip("needs MinGW and Rust's standard library for Windows (Debian: libstd-rust-dev-windows)")
    settings = {"CC": f"{tools}-gcc", "AR": f"{tools}-ar", "CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER": f"{tools}-gcc"}
    cargo("build", "--locked", "--target", target, "--example", "draws", RUSTFLAGS="-D warnings", **settings)
    if WINE:
        lines = windows(cargo.target / target / "debug/examples/draws.exe").splitlines()
        assert hash_of([int(line.split()[-1], 16) for line in lines]) == table()["paths"]
