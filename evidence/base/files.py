# SPDX-License-Identifier: Apache-2.0
"""EXR images, and atomic writes of images and tables."""

import contextlib
import csv
import io

import numpy as np
import OpenEXR

from .atomic_write import write_text, written_beside


def write_image(path, image, **options):
    """Writes a Pillow image."""
    with written_beside(path) as beside:
        image.save(beside, **options)


def read_exr(path):
    """An EXR image as (float32 array (height, width, 3), dict of attributes)."""
    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        pixels = channels["RGBA" if "RGBA" in channels else "RGB"].pixels
        return np.array(pixels[..., :3], np.float32), dict(file.header())


def write_exr(path, rgb, attributes):
    """Writes float32 RGB with string and number attributes."""
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **attributes}
    with written_beside(path) as beside, OpenEXR.File(header, {"RGB": np.ascontiguousarray(rgb, np.float32)}) as file:
        file.write(str(beside))


def read_numbers(path):
    """The rows of a CSV file as dicts; numeric strings become numbers."""
    def number(text):
        for kind in (int, float):
            with contextlib.suppress(ValueError):
                return kind(text)
        return text

    with open(path, newline="", encoding="utf-8") as file:
        return [{name: number(text) for name, text in row.items()} for row in csv.DictReader(file)]


def write_rows(path, fields, rows):
    """Writes dicts as CSV."""
    out = io.StringIO()
    writer = csv.DictWriter(out, fields, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(path, out.getvalue())


def kept(path, again, make):
    """Saves the rows of make() to a CSV file and returns them as read by read_numbers(). With `again`, reads an existing file instead."""
    if not again or not path.is_file():
        rows = list(make())
        write_rows(path, list(rows[0]), rows)
    return read_numbers(path)
