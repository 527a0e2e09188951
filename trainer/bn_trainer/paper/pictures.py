# SPDX-License-Identifier: Apache-2.0
"""Test images for `bn_trainer table`, and the error of their 1-bit dithering after a Gaussian blur."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from ..config import TrainerError

PICTURE_SIZE = 256


def floyd_steinberg(picture: np.ndarray) -> np.ndarray:
    """Error diffusion (Floyd and Steinberg, 1976) of the image with 8 bits, a benchmark that no mask matches."""
    return np.asarray(Image.fromarray(np.uint8(255 * picture + 0.5)).convert("1"), np.float32)


def synthetic_pictures() -> dict[str, np.ndarray]:
    """A grey ramp, a radial gradient, and three lit spheres over a chequered floor: float32 in [0, 1]."""
    n = PICTURE_SIZE
    y, x = (np.mgrid[0:n, 0:n].astype(np.float32) + 0.5) / n
    ramp = x.copy()
    radial = np.clip(1 - np.hypot(x - 0.5, y - 0.5) / np.sqrt(0.5), 0, 1)
    scene = 0.85 - 0.5 * y
    depth = 0.09 / np.maximum(y - 0.55, 1e-3)
    tiles = (np.floor((x - 0.5) * depth * 24) + np.floor(depth * 12)) % 2
    scene = np.where(y > 0.6, (0.25 + 0.35 * tiles) * np.clip((y - 0.55) * 5, 0.2, 1), scene)
    light = np.array([-0.5, -0.6, 0.63])
    for centre_x, centre_y, radius, albedo in ((0.3, 0.5, 0.2, 0.9), (0.68, 0.62, 0.15, 0.5), (0.52, 0.8, 0.1, 0.25)):
        u, v = (x - centre_x) / radius, (y - centre_y) / radius
        w = np.sqrt(np.clip(1 - u * u - v * v, 0, None))
        lit = albedo * np.clip(0.08 + 0.92 * (u * light[0] + v * light[1] + w * light[2]), 0.03, 1)
        scene = np.where(u * u + v * v < 1, lit, scene)
    return {name: picture.astype(np.float32) for name, picture in (("ramp", ramp), ("radial", radial), ("scene", scene))}


def read_picture(argument: str) -> tuple[str, np.ndarray]:
    """(name, grey values in [0, 1]) of a crop of an image file; FILE@X,Y gives the top-left corner of the crop."""
    path, _, corner = argument.partition("@")
    try:
        left, top = (int(word) for word in corner.split(",")) if corner else (0, 0)
        with Image.open(path) as image:
            grey = np.asarray(image.convert("L"), np.float32) / 255
    except (OSError, ValueError) as error:
        raise TrainerError(f"--picture {argument}: {error}; give FILE or FILE@X,Y") from None
    part = grey[top : top + PICTURE_SIZE, left : left + PICTURE_SIZE]
    if left < 0 or top < 0 or part.shape != (PICTURE_SIZE, PICTURE_SIZE):
        raise TrainerError(f"--picture {argument}: {path} has no {PICTURE_SIZE}x{PICTURE_SIZE} pixels at {left},{top}")
    return Path(path).stem, part


def blur(images: Tensor, sigma: float) -> Tensor:
    """Gaussian blur of images (count, height, width) with mirrored edges."""
    radius = int(np.ceil(4 * sigma))
    kernel = torch.exp(-0.5 * (torch.arange(-radius, radius + 1) / sigma).square())
    kernel = kernel / kernel.sum()
    padded = torch.nn.functional.pad(images[:, None], (radius,) * 4, mode="reflect")
    rows = torch.nn.functional.conv2d(padded, kernel[None, None, None, :])
    return torch.nn.functional.conv2d(rows, kernel[None, None, :, None])[:, 0]


def dithering_errors(values: np.ndarray, picture: np.ndarray, sigmas: Sequence[float]) -> np.ndarray:
    """RMSE of 1-bit dithering after blurs with these sigmas; the shape is (sigmas, masks)."""
    repeats = PICTURE_SIZE // values.shape[-1] + 1
    tiled = np.tile(values, (1, repeats, repeats))[:, :PICTURE_SIZE, :PICTURE_SIZE]
    return blurred_errors((picture + tiled >= 1).astype(np.float32), picture, sigmas)


def blurred_errors(dithered: np.ndarray, picture: np.ndarray, sigmas: Sequence[float]) -> np.ndarray:
    """RMSE of dithered images (count, height, width) after blurs with these sigmas; the shape is (sigmas, count)."""
    difference = torch.from_numpy(dithered - picture)
    return np.array([[blur(part[None], sigma).square().mean().sqrt().item() for part in difference] for sigma in sigmas])
