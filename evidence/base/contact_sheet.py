# SPDX-License-Identifier: Apache-2.0
"""Contact sheets: images side by side, enlarged only by integer factors because resampling would change the noise."""

import numpy as np
from PIL import Image, ImageDraw, ImageFont

BACKGROUND, INK = (255, 255, 255), (20, 20, 20)
GAP = 4  # pixels between the images in a cell; cells are 4 gaps apart


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
    """A grid of cells. cells[row][column] is a list of same-sized images, shown from left to right."""
    count, (width, height) = len(cells[0][0]), cells[0][0][0].size
    cell_width = count * width + (count - 1) * GAP
    font = ImageFont.load_default(max(13, height // 13))
    label_width = 2 * GAP + int(max(font.getlength(line) for name in row_names for line in name.split("\n")))
    top = int(font.size * 1.5)
    pitch_x, pitch_y = cell_width + 4 * GAP, height + 4 * GAP
    result = Image.new("RGB", (label_width + len(column_names) * pitch_x, top + len(row_names) * pitch_y), BACKGROUND)
    draw = ImageDraw.Draw(result)
    for x, name in enumerate(column_names):
        draw.text((label_width + x * pitch_x + cell_width / 2, top / 2), name, INK, font, anchor="mm")
    for y, name in enumerate(row_names):
        draw.text((GAP, top + y * pitch_y + height / 2), name, INK, font, anchor="lm")
        for x in range(len(column_names)):
            for i, image in enumerate(cells[y][x]):
                result.paste(image, (label_width + x * pitch_x + i * (width + GAP), top + y * pitch_y))
    return result
