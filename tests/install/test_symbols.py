# SPDX-License-Identifier: Apache-2.0
"""The library exports the functions and tables its headers declare, and nothing else. Its folders include only those below them."""

import re

from conftest import ROOT, VERSION, run


def symbols(*nm_arguments) -> set:
    """The symbol names that nm prints, without version suffixes."""
    names = (line.split()[-1] for line in run("nm", *nm_arguments).splitlines()
             if re.search(r" [A-Za-z] ", line))
    return {name.split("@")[0] for name in names}


def declared() -> set:
    names = []
    for path in (ROOT / "libbn" / "include" / "bn").glob("*.h"):
        header = re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.DOTALL)
        names += re.findall(r"^BN_API\b[^;(]*?\b(\w+)\s*\(", header, re.MULTILINE)
        names += re.findall(r"^BN_API extern\b[^;]*?\b(\w+)\[", header, re.MULTILINE)
    assert len(names) == len(set(names)) >= 10
    return set(names)


def test_shared_library_exports_match_the_headers(shared_library):
    # Some linkers add their own symbols to every library.
    exported = symbols("-D", "--defined-only", shared_library.library) - {"_init", "_fini"}
    assert exported == declared()
    # The list contains each symbol and the version that introduced it. Released symbols must remain.
    listed = dict(line.split() for line in (ROOT / "tests/install/symbols.txt").read_text(encoding="utf-8").splitlines())
    assert exported == set(listed)
    assert all(list(map(int, since.split("."))) <= list(map(int, VERSION.split("."))) for since in listed.values())


def test_static_library_symbols_have_the_prefix(static_library):
    external = symbols("-g", "--defined-only", static_library.library)
    assert declared() <= external
    assert [name for name in external if not name.startswith("bn_")] == []


def test_library_neither_prints_nor_exits(shared_library):
    used = symbols("-D", "--undefined-only", shared_library.library)
    forbidden = {"printf", "fprintf", "vfprintf", "puts", "fputs", "putchar", "perror", "exit", "_exit",
                 "abort", "raise", "__printf_chk", "__fprintf_chk", "__assert_fail", "stderr", "stdout"}
    assert used & forbidden == set()


def test_soname_contains_the_minor_version(shared_library):
    major, minor, _ = VERSION.split(".")
    (name,) = re.findall(r"\(SONAME\).*\[(.+?)\]", run("readelf", "-d", shared_library.library))
    assert name == f"libbn.so.{major}" + (f".{minor}" if major == "0" else "")


def test_shared_library_needs_only_the_c_library(shared_library):
    needed = re.findall(r"\(NEEDED\).*\[(.+?)\]", run("readelf", "-d", shared_library.library))
    assert [name for name in needed if not re.match(r"(libc|libm|ld-linux[\w-]*)\.so", name)] == []


DRAWS = """#include <bn/bn.h>
int main(void) {
    bn_sampler sampler;
    if (bn_sampler_init(&sampler, BN_SAMPLER_MASK, 1) != BN_SUCCESS) return 1;
    float u[4] = {2, 2, 2, 2};
    bn_sample_4d(&sampler, 1, 2, 3, BN_DOMAIN_ROOT, u);
    return !(u[0] < 1);
}
"""


def test_program_that_only_draws_links_no_other_data(static_library, tmp_path):
    """It links only the draw tables and the 64 x 64 mask that the sampler type MASK uses by default."""
    (tmp_path / "draws.c").write_text(DRAWS)
    static_library.compile(tmp_path / "draws.c", tmp_path / "draws")
    run(tmp_path / "draws")
    inside = {name for name in symbols(tmp_path / "draws") if name.startswith("bn_data_") and not name.endswith("_count")}
    assert inside == {"bn_data_mask_64"} and "bn_tables_7" in symbols(tmp_path / "draws")


def test_folders_include_only_what_they_may():
    """CONTRIBUTING.md has the same rules. Outside libbn/src and tests, only public headers are included."""
    may = {"base": "", "simd": "base", "sampler": "base simd", "masks": "base simd", "measure": "base", "neural": "base masks"}
    private = re.compile(rf'^#include "({"|".join(may)})/', re.MULTILINE)
    for folder in ("libbn", "bindings", "examples", "integrations", "evidence/programs", "evidence/plugins"):
        for path in (each for suffix in ("[ch]", "[ch]pp") for each in (ROOT / folder).rglob(f"*.{suffix}")):
            parts = path.relative_to(ROOT).parts
            own = parts[2] if parts[:2] == ("libbn", "src") else None
            assert {*private.findall(path.read_text(encoding="utf-8"))} <= {own, *may.get(own, "").split()}, path
