# SPDX-License-Identifier: Apache-2.0
"""The files in libbn/data match SHA256SUMS, which lists all of them."""

import hashlib
from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "libbn/data"


def test_every_table_and_network_has_its_checksum():
    listed = dict(reversed(line.split()) for line in (DATA / "SHA256SUMS").read_text().splitlines())
    present = {path.name for path in DATA.iterdir() if path.suffix in (".u16", ".u32", ".onnx")}
    assert set(listed) == present
    wrong = [name for name, sum_ in listed.items() if hashlib.sha256((DATA / name).read_bytes()).hexdigest() != sum_]
    assert not wrong
