# SPDX-License-Identifier: Apache-2.0
"""Tiny runs of every feature on multiple threads, which scripts/test repeats under sanitizers."""

import itertools

import numpy as np
import pytest
from pathtracer_driver import SAMPLERS, SCENES
from scene_files import DOWN, FOUR, ball, textured_floor, write_environment

TINY = ["--size", "20x18", "--spp", 2, "--threads", 3]


@pytest.mark.parametrize(("scene", "sampler"), [*zip(SCENES, itertools.cycle(SAMPLERS))])
def test_every_scene_and_sampler_renders(pathtracer, scene, sampler):
    pathtracer.render(*TINY, "--scene", scene, "--sampler", sampler, "--light-samples", 2)


def everything_of_gltf():
    """A scene with textures, alpha masks, normal maps, single-sided surfaces, and all light and material types."""
    g = textured_floor(sampler={}, doubleSided=True)
    grey = {"index": g.texture(FOUR.repeat(8, axis=0).repeat(8, axis=1))}
    rough = {"metallicFactor": 1, "metallicRoughnessTexture": grey}
    ball(g, g.material(pbr=rough, alphaMode="MASK", normalTexture=grey, emissiveTexture=grey, emissiveFactor=[1, 1, 1]), around=6)
    glass = {"KHR_materials_transmission": {"transmissionFactor": 1}}
    ball(g, g.material((1, 1, 1), pbr={"roughnessFactor": 0.4}, extensions=glass), around=6)
    for kind in ("point", "spot", "directional"):
        g.light(kind, 2, light={"spot": {}}, rotation=DOWN, translation=[0, 3, 0])
    return g


@pytest.mark.parametrize("name", ["all.glb", "all.gltf"])
def test_glb_and_gltf_files_render(pathtracer, name):
    path = everything_of_gltf().save(pathtracer.folder / name)
    for options in ([], ["--env", "sky", "--photometric"]):
        pathtracer.render(*TINY, "--scene", path, *options)


def test_environments_merging_and_adaptive_sampling_run(pathtracer):
    sky = write_environment(pathtracer.folder / "sky.exr", np.linspace(0, 1, 32).reshape(4, 8, 1))
    pathtracer.render(*TINY, "--env", sky, "--scene", "lens")
    pathtracer.render("--merge", pathtracer.render(*TINY), pathtracer.render(*TINY, "--first-sample", 2))
    pathtracer.render(*TINY, "--noise", 0.3, "--min-spp", 2, "--spp", 4)
    pathtracer.success("--list-cameras")
