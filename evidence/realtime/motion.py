# SPDX-License-Identifier: Apache-2.0
"""A moving camera: `scripts/bench realtime --motion` measures the noise of averaged one-sample frames of rendered scenes

Each frame is rendered with one sample per pixel (program render_frames) and blended with the frames before it, which are reprojected per
pixel from the depth. Writes evidence/results/motion.* and a table in docs/realtime.md.
"""

import dataclasses
import hashlib
import math
import subprocess
import tempfile
import typing
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import ndimage, sparse

import bluenoise

from ..base.cache import Store, cache_folder
from ..base.command import CommandError
from ..base.files import write_image, write_rows, write_text
from ..base.progress import Progress
from ..base.tables import md_table, update_table
from ..measure.image_error import blurred, displayed
from ..renders.views import CAMERAS, EXPOSURES
from ..samplers import plugins

COMMAND = "scripts/bench realtime --motion"
WIDTH, HEIGHT, DEPTH = 1280, 960, 2  # of the whole image; bounces
CROP = (80, 64)
FRAMES, MEASURED = 22, (17, 19, 21)  # frames rendered, and those whose noise is measured
SEEDS = 2
SCENES = {"penumbra": (400, 520), "cornell": (420, 560), "glossy": (380, 560), "interior": (430, 600)}  # the crop's place in frame 0
SPEEDS = (0.25, 1, 2, 4, 8)  # pixels per frame
MOTIONS = ("pan", "turn", "dolly")
PLURALS = {"pan": "Pans", "turn": "Turns", "dolly": "Dollies"}
WEIGHTS, RESAMPLING, CLAMPED, SIGMAS = (0.1, 0.05), ("bilinear", "bicubic"), (False, True), (0.0, 1.0, 2.1)
MAIN = ("bilinear", False, 0.1)
REFERENCE_SPP, REFERENCE_SEED = 128, 1_000_003
BORDER, AGE = 4, 10  # pixels at the crop's sides that are not measured; frames of history that a measured pixel has at least
SAME_DEPTH, FAR = 0.05, 1e5  # relative difference of depths up to which history is kept; depth of the background


# ---- Cameras

@dataclasses.dataclass(frozen=True)
class Camera:
    eye: tuple
    target: tuple
    fov: float  # vertical, degrees

    def axes(self):
        forward = np.subtract(self.target, self.eye)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, (0, 1, 0))
        right /= np.linalg.norm(right)
        return right, np.cross(right, forward), forward

    @property
    def pixel(self):
        """A pixel's size at distance 1."""
        return math.tan(math.radians(self.fov) / 2) / (HEIGHT / 2)

    def points(self, x, y, depth):
        """World positions of points of the image at a depth along the camera's axis."""
        right, up, forward = self.axes()
        across, along = (x - WIDTH / 2) * self.pixel, (HEIGHT / 2 - y) * self.pixel
        return np.array(self.eye) + depth[..., None] * (forward + across[..., None] * right + along[..., None] * up)

    def project(self, points):
        """x, y and depth of world positions."""
        right, up, forward = self.axes()
        away = points - np.array(self.eye)
        depth = away @ forward
        return WIDTH / 2 + away @ right / depth / self.pixel, HEIGHT / 2 - away @ up / depth / self.pixel, depth


def turned(vector, angle):
    """A vector after a rotation about the vertical axis."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] + s * vector[2], vector[1], c * vector[2] - s * vector[0]])


def moved(camera, motion, amount):
    """The camera after a pan (it rotates in place by an angle), a turn (it orbits the point halfway to the target by an angle) or a dolly (its
    distance from the target grows by a factor of e to the power of `amount`)."""
    eye, target = np.array(camera.eye, float), np.array(camera.target, float)
    if motion == "dolly":
        eye = target + math.exp(amount) * (eye - target)
    else:
        pivot = eye if motion == "pan" else (eye + target) / 2
        eye, target = pivot + turned(eye - pivot, amount), pivot + turned(target - pivot, amount)
    return Camera(tuple(eye), tuple(target), camera.fov)


def centres(corner, shape):
    y, x = np.mgrid[:shape[0], :shape[1]]
    return x + corner[0] + 0.5, y + corner[1] + 0.5


def motion_between(before, now, corner, depth):
    """x and y in the frame before, and the depth there, of the points seen at the centres of the crop's pixels."""
    x, y = centres(corner, depth.shape)
    return before.project(now.points(x, y, np.where(depth > 0, depth, FAR)))


# ---- Rendering

class Frames:
    """Renders frames of one scene. `folder` holds the tables of samplers."""

    def __init__(self, program, scene, folder, size=(WIDTH, HEIGHT), depth=DEPTH):
        self.command, self.folder = [Path(program).resolve(), scene, "{}x{}".format(*size), str(depth)], folder

    def render(self, wanted, crop):
        """float32 [frames][height][width] for tuples (sampler, seed, index, spp, corner, offset, camera)."""
        lines = "".join(" ".join(map(str, (sampler, seed, index, spp, *corner, corner[0] + crop[0], corner[1] + crop[1], *offset,
                                           *camera.eye, *camera.target, camera.fov))) + "\n"
                        for sampler, seed, index, spp, corner, offset, camera in wanted)
        try:
            done = subprocess.run(self.command, input=lines.encode(), capture_output=True, cwd=self.folder, check=True).stdout
        except OSError as error:
            raise CommandError(f"cannot run {self.command[0]} ({error.strerror}); build it with scripts/setup") from None
        except subprocess.CalledProcessError as error:
            raise CommandError(f"{self.command[0].name} failed: {error.stderr.decode(errors='replace').strip()}") from None
        return np.frombuffer(done, np.float32).reshape(len(wanted), crop[1], crop[0])

    def depth(self, camera, corner, crop):
        return self.render([("depth", 0, 0, 1, corner, (0, 0), camera)], crop)[0]


@dataclasses.dataclass(frozen=True)
class Way:
    """A sampler, fixed to the screen or following the image's motion; with new_stream, each frame has its own seed."""

    sampler: str
    follows: bool = False
    new_stream: bool = False

    def frame(self, seed, t, corner, offset, camera):
        own, index = (1000 * (seed + 1) + t, 0) if self.new_stream else (seed, t)
        return self.sampler, own, index, 1, corner, offset if self.follows else (0, 0), camera


def ways_of(files):
    """{name: Way}. files: {name: the path tracer's name of a plug-in}."""
    both = {"padded Sobol'": "sobol", "`blue`": "blue", **files}
    ways = {f"{name}{', following' * follows}": Way(sampler, follows) for name, sampler in both.items() for follows in (False, True)}
    return {**ways, "`blue`, a stream per frame": Way("blue", new_stream=True)}


# ---- A sequence, which ends at the scene's own camera

class Step(typing.NamedTuple):
    """A frame: the camera; the image's motion so far in whole pixels; the crop's corner; and, for each of its pixels, the place in the crop
    of the frame before, and whether that place shows the same surface (None in the first frame)."""

    camera: Camera
    offset: tuple
    corner: tuple
    before: tuple | None
    known: np.ndarray | None


def sequence(frames, scene, motion, speed, corner=None, crop=None, count=None):
    """The Steps of `count` frames. The crop moves with the image, so that its content stays the same."""
    start, corner, crop = Camera(*CAMERAS[scene]), np.array(corner or SCENES[scene]), crop or CROP

    def step(before, now, corner, depth):
        """The motion of the median pixel."""
        return np.array([np.median(here - there) for here, there in zip(centres(corner, depth.shape), motion_between(before, now, corner, depth))])

    amount, depths = 0.0, [frames.depth(start, corner, crop)]
    if speed:  # the amount per frame is in proportion to that of a small motion; pans and turns move the image to the right
        small = 1e-4
        found = step(moved(start, motion, -small), start, corner, depths[0])
        amount = speed * small / np.hypot(*found) * (1 if motion == "dolly" else np.sign(found[0]))
    cameras, motions, corners = [start], [], [corner]
    for t in range(1, count or FRAMES):  # backwards in time
        cameras.append(moved(start, motion, -amount * t) if speed else start)
        motions.append(step(cameras[t], cameras[t - 1], corners[t - 1], depths[t - 1]))
        corners.append(corner - np.floor(np.sum(motions, 0) + 0.5).astype(int))
        depths.append(frames.depth(cameras[t], corners[t], crop))
    pan, (was, *later) = bluenoise.Pan(), list(zip(cameras, corners, depths))[::-1]
    steps = [Step(was[0], (0, 0), tuple(was[1]), None, None)]
    for now, moving in zip(later, motions[::-1]):
        pan.follow(*moving)
        x, y, away = motion_between(was[0], *now)
        x, y = x - was[1][0] - 0.5, y - was[1][1] - 0.5
        seen = was[2][nearest(x, y, crop)]
        known = is_inside(x, y, crop) & (np.abs(np.where(seen > 0, seen, FAR) - away) < SAME_DEPTH * away)
        steps.append(Step(now[0], (int(pan.x), int(pan.y)), tuple(now[1]), (x, y), known))
        was = now
    return steps


def rendered(frames, steps, ways, seeds, crop):
    """float32 [frames][height][width][ways * seeds]."""
    images = frames.render([way.frame(seed, t, step.corner, step.offset, step.camera) for way in ways for seed in range(seeds) for t, step in enumerate(steps)], crop)
    return np.moveaxis(images.reshape(-1, len(steps), *crop[::-1]), 0, -1)


def nearest(x, y, size):
    """The index of the pixels nearest to positions in an image of `size`."""
    return tuple(np.clip(np.rint(at), 0, count - 1).astype(int) for at, count in ((y, size[1]), (x, size[0])))


def is_inside(x, y, size):
    return (x > -0.5) & (x < size[0] - 0.5) & (y > -0.5) & (y < size[1] - 0.5)


# ---- Averaging

def taps(resampling, x, y, size):
    """The sparse matrix that reads an image of `size` at the given positions, in pixels from the first pixel's centre."""
    def along(at):
        first = np.floor(at)
        f = at - first
        if resampling == "bilinear":
            return first, [(0, 1 - f), (1, f)]
        return first, [(-1, ((-0.5 * f + 1) * f - 0.5) * f), (0, (1.5 * f - 2.5) * f * f + 1),  # Catmull and Rom's spline
                       (1, ((-1.5 * f + 2) * f + 0.5) * f), (2, (0.5 * f - 0.5) * f * f)]

    (column, wide), (row, high) = along(x.ravel()), along(y.ravel())
    rows, columns, values = [], [], []
    for dy, down in high:
        for dx, right in wide:
            rows.append(np.arange(x.size))
            columns.append(np.clip(row + dy, 0, size[1] - 1).astype(int) * size[0] + np.clip(column + dx, 0, size[0] - 1).astype(int))
            values.append(down * right)
    found = np.concatenate(values).astype(np.float32), (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_array(found, (x.size, size[0] * size[1]))


COMBINATIONS = tuple((clamped, weight) for clamped in CLAMPED for weight in WEIGHTS)


class Averages:
    """Moving averages of frames [height][width][images], one for each of COMBINATIONS. The first frames of a history have equal weights."""

    def __init__(self, resampling):
        self.resampling = resampling
        self.histories = self.age = None  # [height][width][combinations][images], [height][width]

    def add(self, frame, before, known):
        (height, width, images), count = frame.shape, len(COMBINATIONS)
        if self.histories is None:
            self.histories, self.age = np.repeat(frame[:, :, None], count, 2), np.zeros((height, width), int)
            return
        old = (taps(self.resampling, *before, (width, height)) @ self.histories.reshape(height * width, -1)).reshape(height, width, count, images)
        # Clamping limits the history to the range of values in the frame's 3x3 neighbourhood.
        low, high = (of(frame, (3, 3, 1), mode="nearest") for of in (ndimage.minimum_filter, ndimage.maximum_filter))
        self.age = np.where(known, self.age[nearest(*before, (width, height))] + 1, 0)
        for i, (clamped, weight) in enumerate(COMBINATIONS):
            own = np.clip(old[:, :, i], low, high) if clamped else old[:, :, i]
            share = np.maximum(weight, 1 / (self.age + 1)).astype(np.float32)[..., None]
            self.histories[:, :, i] = own + share * (frame - own)


def measure(frames, scene, motion, speed, ways):
    """Rows with mean squares, as displayed: `noise` is half the difference of two seeds, in which neither blurred history nor the reference
    counts; `total` is the difference from a converged frame, in which both do."""
    steps, exposure = sequence(frames, scene, motion, speed), EXPOSURES.get(scene, 0)
    images = rendered(frames, steps, ways.values(), SEEDS, CROP)
    reference = displayed(frames.render([("sobol", REFERENCE_SEED, 0, REFERENCE_SPP, steps[-1].corner, (0, 0), steps[-1].camera)], CROP)[0], exposure)
    inner = np.zeros(CROP[::-1], bool)
    inner[BORDER:-BORDER, BORDER:-BORDER] = True
    rows = []
    for resampling in RESAMPLING:
        averages, noise, total = Averages(resampling), {sigma: [] for sigma in SIGMAS}, {}
        for t, step in enumerate(steps):
            averages.add(images[t], step.before, step.known)
            if t not in MEASURED:
                continue
            counted = inner & (averages.age >= AGE)
            seen = displayed(averages.histories, exposure).reshape(*CROP[::-1], len(COMBINATIONS), len(ways), SEEDS)
            for sigma in SIGMAS:
                noise[sigma].append((blurred((seen[..., 0] - seen[..., 1]) / math.sqrt(2), sigma)[counted] ** 2).mean(0))
                total[sigma] = (blurred(seen - reference[..., None, None, None], sigma)[counted] ** 2).mean((0, 3))
        rows += [{"way": way, "resampling": resampling, "clamped": clamped, "weight": weight, "sigma": sigma,
                  "noise": float(np.mean(noise[sigma], 0)[i, j]), "total": float(total[sigma][i, j])}
                 for sigma in SIGMAS for i, (clamped, weight) in enumerate(COMBINATIONS) for j, way in enumerate(ways)]
    return rows


# ---- Errors over padded Sobol' with a still camera. The cache's keys contain the source of everything above.

from ..base.page import render

FIELDS = ("motion", "speed", "scene", "way", "resampling", "clamped", "weight", "sigma", "noise", "total")
BASE = "padded Sobol'"
WINNER = 1.03  # ways with at most 3% more than the lowest error are winners too
SETTINGS = {"no blur": (MAIN, 0.0), "sigma 2.1": (MAIN, 2.1), "bicubic": (("bicubic", False, 0.1), 1.0), "clamped": (("bilinear", True, 0.1), 1.0),
            "bicubic, clamped": (("bicubic", True, 0.1), 1.0), "weight 0.05": (("bilinear", False, 0.05), 1.0)}


def rows_of(found):
    """CSV rows from {(scene, motion, speed): rows of measure()}, with geometric means over the scenes in the rows of scene "all"."""
    def setting(row):
        return tuple(row[name] for name in FIELDS[4:8])

    base = {(scene, *setting(row)): row["noise"] for (scene, motion, _), rows in found.items() if motion == "rest" for row in rows if row["way"] == BASE}
    logs, rows = {}, []
    for (scene, motion, speed), own in found.items():
        for row in own:
            logs.setdefault((motion, speed, row["way"], *setting(row)), {})[scene] = [
                0.5 * math.log(row[kind] / base[scene, *setting(row)]) for kind in ("noise", "total")]
    for (motion, speed, way, resampling, clamped, weight, sigma), scenes in logs.items():
        alone = scenes if (resampling, clamped, weight, sigma) == (*MAIN, 1.0) else {}
        rows += [dict(zip(FIELDS, (motion, f"{speed:g}", scene, way, resampling, int(clamped), weight, sigma, *(f"{math.exp(value):.3f}" for value in means))))
                 for scene, means in {"all": np.mean(list(scenes.values()), 0), **alone}.items()]
    return rows


def in_order(rows):
    """{way: {(motion, speed, scene, resampling, clamped, weight, sigma): (noise, total)}}."""
    found = {}
    for row in rows:
        key = row["motion"], float(row["speed"]), *(row[name] for name in ("scene", "resampling", "clamped", "weight", "sigma"))
        found.setdefault(row["way"], {})[key] = float(row["noise"]), float(row["total"])
    return found


def winners_table(head, columns, errors):
    """A row for each way. columns: {heading: key in errors[way]}. Values of at most WINNER times a column's lowest are bold."""
    least = {key: min(own[key][0] for own in errors.values() if key in own) if key in errors.get(BASE, ()) else 0 for key in columns.values()}

    def cell(own, key):
        if key not in own:
            return ""  # not measured
        return f"**{own[key][0]:.2f}**" if own[key][0] <= WINNER * least[key] else f"{own[key][0]:.2f}"

    return md_table([head, *columns], [[way, *(cell(own, key) for key in columns.values())] for way, own in errors.items()])


def at(motion, speed, scene="all", setting=MAIN, sigma=1.0):
    return motion, speed, scene, setting[0], int(setting[1]), setting[2], sigma


def named(speed):
    return {0: "at rest", 0.25: "1/4"}.get(speed, f"{speed:g}")


def main_table(errors):
    columns = {"at rest": at("rest", 0), **{f"{motion}, {named(speed)}": at(motion, speed) for motion in MOTIONS for speed in SPEEDS}}
    return winners_table("pixels per frame", columns, errors)


def summaries(errors):
    """The largest noise of `blue` at 1 pixel per frame or more, relative to its noise at rest, for each motion."""
    lines, speeds = [], [speed for speed in SPEEDS if speed >= 1]
    for motion in MOTIONS:
        most = [max(errors[way][at(motion, speed)][0] for speed in speeds) / errors["`blue`"][at("rest", 0)][0] for way in ("`blue`, following", "`blue`")]
        lines.append(f"- {PLURALS[motion]} of {' to '.join(dict.fromkeys(f'{end:g}' for end in (speeds[0], speeds[-1])))} pixels per frame: at most {most[0]:.2f} times if its "
                     f"draws follow the image, and {most[1]:.2f} times if they are fixed to the screen.")
    return "\n".join(["The noise of `blue`, relative to its noise at rest:", "", *lines])


def settings_table(errors, motion):
    """The columns of SETTINGS at rest, or at 2 pixels per frame."""
    speed = 0 if motion == "rest" else 2
    columns = {name: at(motion, speed, setting=setting, sigma=sigma) for name, (setting, sigma) in SETTINGS.items()}
    return winners_table(f"{motion}, {speed} pixels per frame" if speed else "at rest", columns, errors)


def scenes_table(errors):
    return md_table(["scene", *(f"{name}, {named(speed)}" for name in ("fixed", "following") for speed in SPEEDS)], [
        [scene, *(f"{errors[way][at('pan', speed, scene)][0] / errors['`blue`'][at('rest', 0, scene)][0]:.2f}"
                  for way in ("`blue`", "`blue`, following") for speed in SPEEDS)] for scene in SCENES])


# ---- A film of blue, fixed and following

FILM_SIZE, FILM_CORNER, FILM_FRAMES, FILM_SPEED, GAMMA = (208, 160), (420, 480), 36, 2, 2.2


def film(frames, scene):
    """Images of a crop that moves with a pan: blue fixed to the screen on the left, following the image on the right."""
    steps = sequence(frames, scene, "pan", FILM_SPEED, FILM_CORNER, FILM_SIZE, FILM_FRAMES)
    averages, shown = Averages("bilinear"), []
    for image, step in zip(rendered(frames, steps, (Way("blue"), Way("blue", follows=True)), 1, FILM_SIZE), steps):
        averages.add(image, step.before, step.known)
        own = displayed(averages.histories[:, :, COMBINATIONS.index(MAIN[1:])], EXPOSURES.get(scene, 0)) ** (1 / GAMMA)
        shown.append(np.uint8(255 * np.hstack([own[..., 0], np.ones((FILM_SIZE[1], 8)), own[..., 1]]) + 0.5))
    return np.stack(shown)


# ---- The command

def run(options, packs, heitz, added, earlier):
    """packs: {name: realtime.Slices, or another source of frames}; added: {name: plugins.Plugin}; earlier: rows of the last run, which are kept if they are not measured now."""
    program = options.frames
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        for plugin in plugins.FOLDER.glob("*.so"):
            (Path(folder) / plugin.name).symlink_to(plugin)
        files = {"interleaved gradient noise": "./gradient_noise.so"}
        files |= {name: f"./slices.so:{write_slices(source, Path(folder), f'slices-{i}.bin')}" for i, (name, source) in enumerate(packs.items())}
        if heitz:
            files["Heitz et al. 2019"] = f"./heitz.so:{heitz.write(folder).name}"
        for name, plugin in added.items():
            if plugin.function:
                raise CommandError(f"--sampler {name}=...: a moving camera needs a shared library")
            path, colon, argument = plugin.file.partition(":")
            (Path(folder) / f"{name}.so").symlink_to(path)
            files[name] = f"./{name}.so{colon}{argument}"
        ways, store = ways_of(files), Store(cache_folder() / "motion")
        try:
            key = {"program": hashlib.sha256(program.read_bytes()).hexdigest(), "files": {name: plugins.key_of(file, folder) for name, file in files.items()},
                   "source": hashlib.sha256(Path(__file__).read_bytes().split(b"# ---- Errors over")[0]).hexdigest()}
        except OSError as error:
            raise CommandError(f"cannot read {program} ({error.strerror}); build it with scripts/setup") from None
        wanted = [(scene, "rest", 0) for scene in SCENES] + [(scene, motion, speed) for motion in MOTIONS for speed in SPEEDS for scene in SCENES]
        found = {}
        with Progress(len(wanted), "sequences") as progress:
            for done, at in enumerate(wanted):
                progress("{}, {}, {:g} pixels per frame".format(*at), done)
                found[at], _ = store.get({**key, "ways": {name: dataclasses.astuple(way) for name, way in ways.items()}, "at": at},
                                         lambda at=at: (measure(Frames(program, at[0], folder), *at, ways), {}))
        _, shown = store.get({**key, "film": FILM_SIZE}, lambda: ([], {"film": film(Frames(program, "penumbra", folder), "penumbra")}))
        shown = [Image.fromarray(image) for image in shown["film"]]
    rows = rows_of(found)
    own = {(row["motion"], float(row["speed"]), row["way"]) for row in rows}
    rows += [row for row in earlier if (row["motion"], float(row["speed"]), row["way"]) not in own]
    write_rows(options.out / "motion.csv", FIELDS, rows)
    write_image(options.out / "motion.webp", shown[0], save_all=True, append_images=shown[1:], duration=60, loop=0, quality=60, method=6)
    errors = in_order(rows)
    if not options.print:
        update_table(options.guide, COMMAND, f"{summaries(errors)}\n\n{main_table(errors)}")
    write_text(options.out / "motion.md", page := render(globals(), "motion.md.in", errors=errors))
    print(page)


def write_slices(source, folder, name):
    """A file for the path tracer's sampler slices:FILE: pairs of numbers of each frame of a tile."""
    pairs = source.pairs(FRAMES)
    (folder / name).write_bytes(np.array(pairs.shape[:3], np.uint32).tobytes() + np.ascontiguousarray(pairs, np.float32).tobytes())
    return name
