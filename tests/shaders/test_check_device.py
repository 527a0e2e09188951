# SPDX-License-Identifier: Apache-2.0
"""Tests `scripts/shaders --device` with this machine's drivers and with failing drivers."""

import check_device
from conftest import need_wgpu


def test_all_drivers_match_the_library(capsys):
    need_wgpu()
    assert check_device.main() == 0
    assert all(": all bits match the CPU's (hash " in line for line in capsys.readouterr().out.splitlines())


def test_wrong_bits_and_failing_drivers_are_reported(cases, capsys, monkeypatch):
    words = {asked.tobytes(): bytearray(expected.tobytes()) for asked, expected in zip(cases.asked, cases.expected)}
    words[cases.asked[1].tobytes()][5] ^= 1
    drivers = [("one", lambda *_: 1 / 0), ("two", lambda buffers, *_: words[buffers[2]])]
    monkeypatch.setattr(check_device, "found", lambda: drivers)
    assert check_device.main() == 1
    one, two = capsys.readouterr().out.splitlines()
    assert one == "one: division by zero" and two.startswith("two: bits differ from the CPU's in 1 of 155,520 cases (hash ")
    drivers.clear()
    assert "found no driver" in check_device.main()
