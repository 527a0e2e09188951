# SPDX-License-Identifier: Apache-2.0
"""Films: `scripts/bench films` compares ways to number the samples of frames, and writes evidence/results/films.*"""

import dataclasses
import hashlib
from pathlib import Path

import numpy as np

from ..base.cache import Store, cache_folder
from ..base.command import Parser, command_shown
from ..base.files import write_rows
from ..base.page import write_page
from ..base.progress import Progress
from ..base.tables import md_table
from ..measure.compare import REFERENCE_MARGIN
from ..measure.image_error import SIGMAS, blurred, displayed
from ..measure.statistics import estimate
from ..realtime.motion import HEIGHT, WIDTH, Camera, Frames, moved
from ..renders.views import BUILT_IN, CAMERAS, EXPOSURES, View, crops

COUNTS, REFERENCE_SEED, DEPTH = (4, 16), 1_000_003, 8
# {way: text}. Frames of the base are independent: each has its own seed, which is as good as a stream.
BASE, STILL, PANS = "stream", {"count": "continue the index", "wide": "continue the index, stride four times as large"}, {"count": "continue the index", "follow": "continue the index and follow"}
MEAN_OF, CROP = 4, (48, 36)
PAN_FRAMES, PAN_CROP, SPEEDS = 8, (112, 40), (1, 3, 8)  # SPEEDS: pixels per frame
PAN_SCENES = {"cornell": (560, 640), "interior": (560, 590), "lens": (540, 400)}  # the crop's corner in the first frame
GAZES = ("follows", "is fixed")
# The temporal response of the eye: the sustained channel of FovVideoVDP (Mantiuk et al., "FovVideoVDP: A Visible Difference Predictor for
# Wide Field-of-View Video", 2021), with the parameters of its version 1.2. Seconds.
PEAK, SPREAD, RATES = 0.06, 0.5, (24, 60)  # RATES: frames per second


def eye_weights(rate, count=PAN_FRAMES):
    """The share of each frame, the oldest first, in what the eye sees when the newest frame ends. Each is shown until the next one."""
    ago = (np.arange(count * 200) + 0.5) / 200 / rate  # seconds
    response = np.exp(-np.log(ago / PEAK) ** 2 / (2 * SPREAD**2))
    shares = response.reshape(count, 200).sum(1)[::-1]
    return shares / shares.sum()


def own_samples(way, seed, frame, spp):
    """(seed, index of the first sample) of a frame."""
    if way == BASE:
        return 1000 * (seed + 1) + frame, 0
    return seed, frame * spp * (4 if way == "wide" else 1)


def by_sigma(name, error):
    return {f"{name}, {sigma}": float(np.sqrt(np.mean(blurred(error, sigma) ** 2))) for sigma in SIGMAS}


# ---- Films: a list of (camera, corner of the crop, draw offset if the draws follow) for each view

def still_film(view):
    values = dict(zip(view.camera[::2], view.camera[1::2]))
    eye, target = (tuple(map(float, values[name].split(","))) for name in ("--eye", "--target"))
    return [(Camera(eye, target, float(values["--fov"])), view.crop[:2], (0, 0))] * MEAN_OF


def pan_film(scene, speed):
    """The camera turns to the left, so that the image, and with it the crop, moves to the right."""
    camera, (x, y) = Camera(*CAMERAS[scene]), PAN_SCENES[scene]
    middle = np.add((x, y), np.array(PAN_CROP) / 2)
    point = camera.points(*middle, np.array(1.0))

    def turned(shift):
        angle = shift * camera.pixel
        for _ in range(3):  # until the crop's middle moves by `shift` pixels
            angle *= shift / (moved(camera, "pan", angle).project(point)[0] - middle[0])
        return moved(camera, "pan", angle)

    return [(turned(speed * k) if k else camera, (x + speed * k, y), (speed * k, 0)) for k in range(PAN_FRAMES)]


def seen(errors, weights, speed, gaze):
    """What the eye sees of the errors of frames, whose crops move with the image. A fixed gaze sees the part of the screen in all of them."""
    if gaze == "follows":
        return np.tensordot(weights, errors, 1)
    last = len(errors) - 1
    width = PAN_CROP[0] - speed * last
    return sum(weight * error[:, speed * (last - k):][:, :width] for k, (weight, error) in enumerate(zip(weights, errors)))


def still_errors(frames):
    alone = [by_sigma("one frame", error) for error in frames]
    return {**{name: float(np.sqrt(np.mean([each[name] ** 2 for each in alone]))) for name in alone[0]}, **by_sigma(f"mean of {MEAN_OF}", np.mean(frames, 0))}


def pan_errors(speed):
    return lambda frames: {name: value for gaze in GAZES for rate in RATES
                           for name, value in by_sigma(f"gaze {gaze}, {rate} fps", seen(frames, eye_weights(rate), speed, gaze)).items()}


class Render:
    """Renders films, and measures each way to number samples."""

    def __init__(self, options):
        self.program, self.seeds = options.frames, options.seeds
        self.store = Store(cache_folder() / "films")
        self.sum = hashlib.sha256(Path(self.program).read_bytes()).hexdigest()

    def images(self, scene, size, crop, wanted):
        """Displayed frames for tuples as Frames.render() takes them, from the cache or rendered now."""
        def render():
            frames = Frames(self.program, scene, ".", size, DEPTH)
            return {}, {"images": frames.render(wanted, crop)}

        key = [self.sum, scene, size, crop, DEPTH, [[*own[:-1], dataclasses.astuple(own[-1])] for own in wanted]]
        return displayed(self.store.get(key, render)[1]["images"], EXPOSURES.get(scene, 0))

    def measure(self, view, film, ways, counts, errors_of, spp, crop):
        """{(way, count, measure): errors, one per seed}, and the own error of the mean of the references for each measure."""
        size = view.width, view.height
        # Half of the samples at a time: half of their difference is the references' own error.
        halves = [self.images(view.file, size, crop, [("sobol", REFERENCE_SEED + k, half * spp // 2, spp // 2, corner, (0, 0), camera)
                                                      for k, (camera, corner, _) in enumerate(film)]) for half in (0, 1)]
        wanted, own = np.mean(halves, 0), errors_of((halves[0] - halves[1]) / 2)
        tasks = [(way, count, seed) for way in (BASE, *ways) for count in counts for seed in range(self.seeds)]
        rendered = self.images(view.file, size, crop, [
            ("blue", *own_samples(way, seed, k, count), count, corner, offset if way == "follow" else (0, 0), camera)
            for way, count, seed in tasks for k, (camera, corner, offset) in enumerate(film)])
        found = {}
        for (way, count, _), frames in zip(tasks, rendered.reshape(len(tasks), len(film), *rendered.shape[1:])):
            for name, error in errors_of(frames - wanted).items():
                found.setdefault((way, count, name), []).append(error)
        return found, own


# ---- Results

def ratios(measured, ways):
    """{(way, count, measure): Estimate over the views {view: result of Render.measure()}}. Ratios count where the references are accurate enough."""
    logs = {}
    for view, (found, own) in measured.items():
        for (way, count, name), errors in found.items():
            base = found[BASE, count, name]
            least = min(*errors, *base)  # 0 where nothing but a light or darkness is visible
            if way in ways and 0 < least >= REFERENCE_MARGIN * own[name]:
                logs.setdefault((way, count, name), {})[view] = np.log(errors) - np.log(base)
    return {key: estimate(of) for key, of in logs.items()}


def table(head, columns, rows, counts=COUNTS):
    """A table of Estimates. columns: {heading: (results of ratios(), measure)}; rows: {way: text}."""
    return md_table([head, *columns], [
        [f"{text}, {count} samples", *(found[way, count, name].text() if (way, count, name) in found else "" for found, name in columns.values())]
        for way, text in rows.items() for count in counts])


def still_table(found):
    return table("error over a stream per frame", {
        f"{what}, {f'sigma {sigma}' if sigma else 'no blur'}": (found, f"{what}, {sigma}") for what in ("one frame", f"mean of {MEAN_OF}") for sigma in SIGMAS}, STILL)


def scenes_table(measured):
    scenes = {view.scene: ratios({own: measured[own] for own in measured if own.scene == view.scene}, STILL) for view in measured}
    return table(f"mean of {MEAN_OF}, sigma 2.1", {scene: (own, f"mean of {MEAN_OF}, 2.1") for scene, own in scenes.items()}, {"count": STILL["count"]})


def pans_table(found, rate=24):
    return table("error over a stream per frame", {
        f"gaze {gaze}, {speed} px": (found[speed], f"gaze {gaze}, {rate} fps, 2.1") for gaze in GAZES for speed in SPEEDS}, PANS, COUNTS)


def run(arguments):
    parser = Parser("films", __doc__)
    parser.number("--seeds", 4, "number of seeds per crop")
    parser.number("--reference-spp", 512, "samples per pixel of the references, an even number")
    parser.out()
    parser.hidden("--frames", "build/evidence/programs/render_frames")
    options = parser.parse_args(arguments)
    if options.reference_spp % 2:
        parser.error(f"--reference-spp must be even, not {options.reference_spp}")
    options.command = command_shown("films", arguments)
    render, views = Render(options), crops(scenes=BUILT_IN, crop=CROP)
    pan_views = {(scene, speed): View(scene, f"pan {speed}", WIDTH, HEIGHT) for scene in PAN_SCENES for speed in SPEEDS}
    still, pans, done = {}, {speed: {} for speed in SPEEDS}, 0
    with Progress(len(views) + len(pan_views), "films") as progress:
        for view in views:
            still[view] = render.measure(view, still_film(view), STILL, COUNTS, still_errors, options.reference_spp, CROP)
            progress(view.label, done := done + 1)
        for (scene, speed), view in pan_views.items():
            pans[speed][view] = render.measure(view, pan_film(scene, speed), PANS, COUNTS, pan_errors(speed), options.reference_spp, PAN_CROP)
            progress(view.label, done := done + 1)
    found = {0: ratios(still, STILL), **{speed: ratios(own, PANS) for speed, own in pans.items()}}
    write_rows(options.out / "films.csv", ("speed", "way", "spp", "measure", "error", "low", "high", "crops"), [
        {"speed": speed, "way": way, "spp": count, "measure": name, "crops": own.crops, **own.ends()}
        for speed, part in found.items() for (way, count, name), own in part.items()])
    write_page(options.out / "films.md", globals(), found=found, still=still, options=options)
