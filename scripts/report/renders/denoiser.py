# SPDX-License-Identifier: Apache-2.0
"""Denoises pictures with few samples with Open Image Denoise, in three ways.

By default the denoiser gets colour, albedo and normal, as from most renderers. A renderer has two cheap alternatives:
to take albedo and normal from additional primary rays; and to keep directly visible light, whose edges do not show in
albedo and normal, out of the denoiser and add it afterwards from the same rays. The package `pyoidn` is optional.
"""

import dataclasses
import importlib.metadata
import threading

import numpy as np
import OpenEXR

from ..base.command import package
from ..measure.image_error import displayed_rmse, relative_rmse, trimmed_relative_rmse
from .judge import Run
from .renderer import progressive

# What the denoiser is given.
WAYS = {
    "plain": "colour, albedo and normal of the same samples",
    "primary": "albedo and normal of additional primary rays, declared noise-free (`cleanAux`)",
    "apart": "as `primary`, with directly visible light added after denoising, from the same rays",
}
MEASURES = {"relative": "relative RMSE", "trimmed": "trimmed relative RMSE", "displayed": "RMSE as displayed, unblurred",
            "displayed_2.1": "RMSE as displayed, after sigma 2.1"}
PRIMARY_RAYS, PRIMARY_SAMPLER, PRIMARY_SEED = 16, "blue", 500_000

# All calls share one filter and its threads.
_LOCK = threading.Lock()


def load():
    """(denoise(colour, albedo, normal, clean), version)."""
    pyoidn = package("pyoidn", ".venv/bin/python -m pip install pyoidn")

    def denoise(colour, albedo, normal, clean):
        arrays = [np.ascontiguousarray(array, np.float32) for array in (np.maximum(colour, 0), np.clip(albedo, 0, 1), normal)]
        with _LOCK:
            return pyoidn.denoise(arrays[0], albedo=arrays[1], normal=arrays[2], hdr=True, clean_aux=clean)

    return denoise, importlib.metadata.version("pyoidn")


# ---- Pictures with their layers

def read_layers(path):
    """(float32 array (height, width, 9), attributes): colour, albedo and normal of a path-traced picture."""
    names = [*"RGB", *(f"albedo.{c}" for c in "RGB"), *(f"normal.{c}" for c in "XYZ")]
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[name].pixels.astype(np.float32) for name in names], -1), dict(file.header())


@dataclasses.dataclass(frozen=True)
class Layers:
    """The input of the denoiser; lamps is the directly visible light in its colour."""

    colour: np.ndarray
    albedo: np.ndarray
    normal: np.ndarray
    lamps: np.ndarray


def layers_of(program, view, sampler, seed, counts):
    """{count: Layers}."""
    request = view.request(sampler, 1, seed)
    seen = dataclasses.replace(request, more=(*request.more, "--max-depth", "0"))
    lamps = {spp: picture[..., :3] for spp, picture, _ in progressive(program, seen, counts, 1, read_layers)}
    return {spp: Layers(whole[..., :3], whole[..., 3:6], whole[..., 6:], lamps[spp])
            for spp, whole, _ in progressive(program, request, counts, 1, read_layers)}


def primary_rays(program, view, seed):
    """Layers from additional primary rays: directly visible light, albedo and normal."""
    request = view.request(PRIMARY_SAMPLER, 1, PRIMARY_SEED + seed)
    seen = dataclasses.replace(request, more=(*request.more, "--max-depth", "0"))
    (_, picture, _), = progressive(program, seen, [PRIMARY_RAYS], 1, read_layers)
    return Layers(picture[..., :3], picture[..., 3:6], picture[..., 6:], picture[..., :3])


def denoised(denoise, way, picture, rays):
    if way == "plain":
        return denoise(picture.colour, picture.albedo, picture.normal, False)
    if way == "primary":
        return denoise(picture.colour, rays.albedo, rays.normal, True)
    return denoise(picture.colour - picture.lamps, rays.albedo, rays.normal, True) + rays.lamps


# ---- Measures

def errors(image, reference, exposure):
    """{measure: error} for all MEASURES."""
    return {"relative": relative_rmse(image, reference), "trimmed": trimmed_relative_rmse(image, reference),
            **{f"displayed_{sigma}" if sigma else "displayed": displayed_rmse(image, reference, exposure, sigma)
               for sigma in (0.0, 2.1)}}


def own_errors(reference, first_half, exposure):
    """{measure: error} of the reference itself: half the difference between the means of its two halves."""
    second_half = 2 * np.asarray(reference, np.float64) - first_half
    return {name: error / 2 for name, error in errors(first_half, np.maximum(second_half, 0), exposure).items()}


class DenoisedRun(Run):
    """A judge.Run that measures pictures after denoising, in all WAYS."""

    def __init__(self, program, most_spp, jobs, denoiser):
        super().__init__(program, "denoised", most_spp, jobs)
        self.denoise, self.version = denoiser

    def key(self, task, reference):
        return {**super().key(task, reference), "denoiser": self.version, "rays": [PRIMARY_RAYS, PRIMARY_SAMPLER],
                "primary": self.builds.key(task.view, PRIMARY_SAMPLER)}

    def measure(self, task, reference):
        """(rows with measures named WAY:MEASURE, no pictures)."""
        pictures = layers_of(self.program, task.view, task.variant.sampler, task.seed, task.counts)
        rays = primary_rays(self.program, task.view, task.seed)
        return [{"spp": spp, **{
            f"{way}:{name}": error for way in WAYS
            for name, error in errors(denoised(self.denoise, way, picture, rays), reference.picture, reference.exposure).items()}}
            for spp, picture in pictures.items()], {}
