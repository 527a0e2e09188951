# SPDX-License-Identifier: Apache-2.0
"""Contact sheets: images side by side, enlarged only by integer factors because resampling would change the noise."""

import numpy as np
from PIL import Image, ImageDraw, ImageFont

BACKGROUND, INK = (255, 255, 255), (20, 20, 20)
GAP = 4  # pixels between the images of labelled(); those of sheet() are 4 gaps apart


def enlarged_part(image, box, factor):
    """The part (left, top, width, height) of an image, with each pixel repeated factor x factor times."""
    left, top, width, height = box
    part = image.crop((left, top, left + width, top + height))
    return part.resize((width * factor, height * factor), Image.Resampling.NEAREST)


def grey(values):
    """An array of bytes as a grey RGB image."""
    return Image.fromarray(values).convert("RGB")


def preview(rgb, exposure=0.0):
    """Linear radiance as an 8-bit image, with the path tracer's tone curve, at `exposure` stops."""
    shoulder, light = 0.6, np.maximum(np.asarray(rgb, np.float64) * 2.0**exposure, 0)
    light = np.where(light < shoulder, light, 1 - (1 - shoulder) * np.exp(np.minimum(shoulder - light, 0) / (1 - shoulder)))
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return Image.fromarray(np.floor(255 * encoded + 0.5).astype(np.uint8))


def labelled(columns, bar, size):
    """A sheet with one column of images for each {label: images}. Labels have `bar` pixels above the columns and a font of `size` pixels."""
    width, height = next(iter(columns.values()))[0].size
    rows = max(map(len, columns.values()))
    figure = Image.new("RGB", (len(columns) * (width + GAP) - GAP, bar + rows * (height + GAP) - GAP), BACKGROUND)
    draw, font = ImageDraw.Draw(figure), ImageFont.load_default(size)
    for i, (text, images) in enumerate(columns.items()):
        x = i * (width + GAP)
        draw.multiline_text((x + width / 2, bar / 2), text, INK, font, anchor="mm", align="center", spacing=2)
        for row, image in enumerate(images):
            figure.paste(image, (x, bar + row * (height + GAP)))
    return figure


def sheet(cells, row_names, column_names):
    """A grid of images cells[row][column] of the same size."""
    width, height = cells[0][0].size
    font = ImageFont.load_default(max(13, height // 13))
    left = 2 * GAP + int(max(font.getlength(line) for name in row_names for line in name.split("\n")))
    top, across, down = int(font.size * 1.5), width + 4 * GAP, height + 4 * GAP
    result = Image.new("RGB", (left + len(column_names) * across, top + len(row_names) * down), BACKGROUND)
    draw = ImageDraw.Draw(result)
    for x, name in enumerate(column_names):
        draw.text((left + x * across + width / 2, top / 2), name, INK, font, anchor="mm")
    for y, name in enumerate(row_names):
        draw.text((GAP, top + y * down + height / 2), name, INK, font, anchor="lm")
        for x in range(len(column_names)):
            result.paste(cells[y][x], (left + x * across, top + y * down))
    return result
