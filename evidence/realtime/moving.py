# SPDX-License-Identifier: Apache-2.0
"""One sample a frame from a moving camera: `scripts/bench moving` renders frames, accumulates them as games do, and measures

The camera pans, orbits and then stands still. What was accumulated is reprojected with the motion of the first surface, where that
was in view, and clamped to what its neighbours show now, or not. Errors are those of pictures as displayed, after a blur of 1.0
pixels, against references; flicker is the deviation over time while the camera stands still. With the package pyoidn, each frame
is also denoised. It writes tables in evidence/results/realtime.md and the picture docs/realtime.webp.
"""

import functools
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from scipy import ndimage

from ..base.cache import Store, cache_folder
from ..base.command import CommandError, Parser
from ..base.files import sha256_of, write_image
from ..base.progress import Progress, in_parallel
from ..base.tables import md_table, write_or_print
from ..measure.image_error import blurred, displayed
from ..renders import denoise as denoising
from .realtime import MovedMask, add_packs, code, packs_of

COMMAND = "scripts/bench moving"
PROGRAM = Path(__file__).resolve().parents[2] / "build/evidence/programs/bench_frames"
SCENES = {"penumbra": 0.0, "cornell": 1.0}  # and exposures, in stops
WIDTH, HEIGHT, PHASE = 160, 120, 20         # pixels; frames of each of the three movements
WEIGHT, SIGMA = 0.1, 1.0
FIRST, STEP, REFERENCE_SPP, REFERENCE_SEED = 11, 6, 256, 1_000_003
STILL = 2 * PHASE  # the first frame of the camera at rest
SETTLED = STILL + 8
TOLERANCE = 0.05   # of distances, for a surface to count as the one of the frame before
HISTORIES = {"bilinear": (False, None), "Catmull-Rom": (True, None), "Catmull-Rom, clamped": (True, 1.25)}
DENOISED = "denoised alone"
MOVING, AT_REST, NOISE, FLICKER = "error, moving", "error, at rest", "noise, moving", "flicker"
WAYS = {"white": ("white", "screen"), "sobol": ("sobol", "screen"), "blue": ("blue", "screen"),
        "blue, a new key every frame": ("blue", "key")}
PARTS = {"checkerboard": "1/2, checkerboard", "columns": "1/2, every second column", "half": "1/4, half the resolution",
         "quarter": "1/16, a quarter of the resolution"}
GIVEN = {"screen": "", "small": ", the smaller picture's `x, y`", "frame": ", index `t`"}
MANY = 32  # samples of a frame that counts as free of noise; accumulated, it still lags, and edges move in the pixel


# ---- Frames, by evidence/programs/bench_frames.cpp

def frames(scene, draws, part="full", given="screen", seed=0, samples=1, first=0, step=1, size=(WIDTH, HEIGHT), phase=PHASE):
    """Yields frames, float32 (height, width, 13)."""
    command = [PROGRAM, scene, *size, phase, seed, draws, part, given, samples, first, step]
    with subprocess.Popen([*map(str, command)], stdout=subprocess.PIPE) as process:
        for _ in range(first, 3 * phase, step):
            data = process.stdout.read(size[0] * size[1] * 13 * 4)
            if len(data) != size[0] * size[1] * 13 * 4:
                raise CommandError(f"{PROGRAM} ended early")
            yield np.frombuffer(data, np.float32).reshape(size[1], size[0], 13)


def write_slices(path, stack):
    path.write_bytes(np.array(stack.shape[:3], np.uint32).tobytes() + np.ascontiguousarray(stack[..., :2], np.float32).tobytes())


def references(scene):
    """{frame: picture}, kept in the cache while the program stays the same."""
    store = Store(cache_folder() / "references")
    key = {"moving": [scene, WIDTH, HEIGHT, PHASE, REFERENCE_SPP], "program": sha256_of(PROGRAM)}
    _, found = store.get(key, lambda: ([], {"frames": np.stack([frame[..., :3] for frame in frames(
        scene, "blue", "full", "pixel", REFERENCE_SEED, REFERENCE_SPP, FIRST, STEP)])}))
    return dict(zip(range(FIRST, 3 * PHASE, STEP), found["frames"]))


# ---- Accumulation

TO_YCOCG = np.array([[.25, .5, .25], [.5, 0, -.5], [-.25, .5, -.25]], np.float32)
FROM_YCOCG = np.linalg.inv(TO_YCOCG).astype(np.float32)


def means(picture, there, width):
    """The mean of what is there in a window, where there is something, and how much is."""
    sizes = (width, width, 1)
    count = ndimage.uniform_filter(there.astype(np.float32), sizes, mode="nearest")
    return ndimage.uniform_filter(picture * there, sizes, mode="nearest") / np.maximum(count, np.float32(1e-6)), count


def cubic(f):
    """Weights of Catmull-Rom for the texels at -1, 0, 1 and 2."""
    return np.stack([f * (-.5 + f * (1 - .5 * f)), 1 + f * f * (-2.5 + 1.5 * f), f * (.5 + f * (2 - 1.5 * f)), f * f * (-.5 + .5 * f)])


class Taps:
    """Where the surfaces of a frame were in the frame before: for each of 4x4 texels around, its index and whether it shows the
    same surface; the weights of the inner four, and of all sixteen."""

    def __init__(self, frame, before):
        height, width = frame.shape[:2]
        x, y, then, normal = frame[..., 9], frame[..., 10], frame[..., 12], frame[..., 6:9]
        left, top = np.floor(x).astype(np.int32), np.floor(y).astype(np.int32)
        self.at, self.good = [], []
        for k in range(16):
            column, row = left + k % 4 - 1, top + k // 4 - 1
            seen = (column >= 0) & (column < width) & (row >= 0) & (row < height) & (then > 0)
            self.at.append(np.where(seen, row * width + column, 0))
            there = before.reshape(-1, 13)[self.at[-1]]
            same = np.abs(there[..., 11] - then) < TOLERANCE * then
            self.good.append(seen & same & (np.einsum("yxc,yxc->yx", there[..., 6:9], normal) > 0.8))
        fx, fy = x - left, y - top
        self.inner = [(5 + i + 4 * j, wx * wy * self.good[5 + i + 4 * j])
                      for j, wy in enumerate((1 - fy, fy)) for i, wx in enumerate((1 - fx, fx))]
        self.share = sum(weight for _, weight in self.inner)
        self.known = self.share > 0.05
        self.all_good = np.logical_and.reduce(self.good)
        self.outer = [wx * wy for wy in cubic(fy) for wx in cubic(fx)]

    def bilinear(self, values):
        """(height, width, channels), of the texels that show the same surface."""
        values = values.reshape(-1, values.shape[-1])
        total = sum(weight[..., None] * values[self.at[k]] for k, weight in self.inner)
        return total / np.maximum(self.share, np.float32(1e-6))[..., None]

    def smooth(self, values):
        """By Catmull-Rom's cubic where all texels show the same surface."""
        flat = values.reshape(-1, values.shape[-1])
        sharp = sum(weight[..., None] * flat[at] for weight, at in zip(self.outer, self.at))
        return np.where(self.all_good[..., None], np.maximum(sharp, 0), self.bilinear(values))


class Accumulations:
    """Moving averages that follow surfaces, for all HISTORIES. The newest frame has the weight of a plain mean until that falls to
    WEIGHT."""

    def __init__(self, names=tuple(HISTORIES)):
        self.names, self.before = names, None

    def add(self, frame):
        """{history: average} after one more frame."""
        light, drawn = np.nan_to_num(frame[..., :3]), np.isfinite(frame[..., 0])[..., None]
        width = 3
        while (near := means(light, drawn, width))[1].min() * width**2 < 7.5:  # frames of parts have holes
            width += 2
        if self.before is None:
            self.pictures, self.count = dict.fromkeys(self.names, light), np.zeros_like(drawn, np.float32)
            known = np.zeros_like(drawn)
        else:
            taps = Taps(frame, self.before)
            known, self.count = taps.known[..., None], taps.known[..., None] * taps.bilinear(self.count)
        colour = light @ TO_YCOCG.T
        middle, square = means(colour, drawn, width)[0], means(colour**2, drawn, width)[0]
        weight = np.where(known, np.maximum(np.float32(WEIGHT), 1 / (self.count + 1)), 1)
        for name in self.names:
            smooth, clamp = HISTORIES[name]
            history = self.pictures[name]
            if self.before is not None:
                history = taps.smooth(history) if smooth else taps.bilinear(history)
            if clamp:
                reach = np.float32(clamp) * np.sqrt(np.maximum(square - middle**2, 0))
                history = np.clip(history @ TO_YCOCG.T, middle - reach, middle + reach) @ FROM_YCOCG.T
            newest = np.where(known, history + weight * (light - history), light)
            self.pictures[name] = np.where(drawn, newest, np.where(known, history, near[0]))
        self.count, self.before = self.count + drawn, frame
        return dict(self.pictures)


# ---- Measures

def error(picture, reference, exposure):
    return np.mean(blurred(displayed(picture, exposure) - displayed(reference, exposure), SIGMA) ** 2)


@functools.lru_cache
def free_of_noise(scene):
    return list(frames(scene, "blue", seed=REFERENCE_SEED, samples=MANY))


@functools.lru_cache
def accumulated_without_noise(scene, part, times):
    """{frame: {history: average}} of frames without noise."""
    averages, kept = Accumulations(), {}
    for t, (frame, shape) in enumerate(zip(free_of_noise(scene), frames(scene, "white", part))):
        pictures = averages.add(np.where(np.isfinite(shape[..., :1]), frame, shape))
        if t in times:
            kept[t] = pictures
    return kept


def measure(scene, wanted, denoise, draws, part, given, seed):
    """{(history, measure): mean square}: errors while the camera moves and at rest, what of the former is noise, and flicker. Draws
    None are frames without noise."""
    exposure, averages, found, over_time = SCENES[scene], Accumulations(), {}, {}
    clean = accumulated_without_noise(scene, part, tuple(wanted))
    each = frames(scene, draws, part, given, seed) if draws else free_of_noise(scene)
    for t, frame in enumerate(each):
        pictures = averages.add(frame)
        if denoise and draws and part == "full" and (t in wanted or t >= SETTLED):
            pictures[DENOISED] = denoise(frame[..., :3], frame[..., 3:6], frame[..., 6:9], True)
        for name, picture in pictures.items():
            if t in wanted:
                found.setdefault((name, MOVING if t < STILL else AT_REST), []).append(error(picture, wanted[t], exposure))
                if t < STILL and name in clean[t]:
                    found.setdefault((name, NOISE), []).append(error(picture, clean[t][name], exposure))
            if t >= SETTLED:
                over_time.setdefault(name, []).append(blurred(displayed(picture, exposure), SIGMA))
    return {**{place: np.mean(each) for place, each in found.items()},
            **{(name, FLICKER): np.mean(np.var(each, axis=0)) for name, each in over_time.items()}}


def measure_all(tasks, scenes, seeds, denoise, jobs):
    """{task: {place: error over that of white noise on every pixel}}, geometric means over scenes; `tasks` are (draws, part, given)."""
    runs = [(scene, task, seed) for scene in scenes for task in tasks for seed in range(seeds)]
    wanted, found = {}, {}
    with Progress(len(runs) + len(scenes), "runs") as progress:
        for scene in scenes:
            wanted[scene] = references(scene)
            progress(f"references of {scene}", len(wanted))
        for run, own in in_parallel(jobs, lambda run: measure(run[0], wanted[run[0]], denoise, *run[1], run[2]), runs):
            found[run] = own
            progress(f"{run[0]}, {' '.join(map(str, run[1]))}", len(scenes) + len(found))

    def mean(scene, task, place):
        return np.mean([found[scene, task, seed][place] for seed in range(seeds)])

    base = tasks[0]
    return {task: {place: float(np.exp(np.mean([np.log(max(mean(scene, task, place) / mean(scene, base, place), 1e-9)) / 2 for scene in scenes])))
                   for place in found[scenes[0], task, 0]} for task in tasks}


# ---- Tables

def table(result, names, places, first):
    rows = [[name, *(f"{result[task][place]:.2f}" if place in result[task] else "" for place in places)] for name, task in names.items()]
    return md_table([first, *(f"{measure}: {history}" for history, measure in places)], rows)


# ---- The picture

def animation(scene, columns, path, size=(200, 150), shown=range(8, 3 * PHASE)):
    """An animated WebP of accumulated frames side by side, at 1:1 pixels."""
    pictures, font = [], ImageFont.load_default(13)
    strips = [[averages.add(frame)["Catmull-Rom"] for frame in frames(scene, draws, "full", given, seed=1, size=size)]
              for draws, given in columns.values() for averages in [Accumulations(("Catmull-Rom",))]]
    for t in shown:
        whole = np.concatenate([displayed(strip[t], SCENES[scene]) for strip in strips], 1)
        image = Image.new("RGB", (whole.shape[1], size[1] + 20), "white")
        image.paste(Image.fromarray(np.uint8(255 * whole ** (1 / 2.2) + 0.5)), (0, 20))
        for i, name in enumerate(columns):
            ImageDraw.Draw(image).text(((i + 0.5) * size[0], 10), name, "black", font, anchor="mm")
        pictures.append(image)
    write_image(path, pictures[0], save_all=True, append_images=pictures[1:], duration=66, loop=0, quality=80, method=6)


# ---- The command

def run(arguments):
    parser = Parser("moving", __doc__)
    parser.number("--seeds", 2, "seeds of each sampler")
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=list(SCENES), help="default: all")
    add_packs(parser, ("STBN", "FAST"))
    parser.number("--jobs", 2, "runs at a time")
    parser.hidden("--picture", "docs/realtime.webp")
    parser.table("evidence/results/realtime.md")
    options = parser.parse_args(arguments)
    try:
        denoise, _ = denoising.load()
    except CommandError as missing:
        print(f"{missing}, for the columns of denoised frames")
        denoise = None
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        ways = dict(WAYS)
        stacks = {"mask + R2": np.stack([MovedMask().frame(t, 2, 0, 64) for t in range(3 * PHASE)]),
                  **{name: pack.stack_for(2) for name, pack in packs_of(options).items()}}
        for name, stack in stacks.items():
            if stack.shape[-1] < 2:
                raise CommandError(f"--{name.lower()}: the pack has no two-vectors")
            ways[name] = (f"{folder}/{len(ways)}.slices", "screen")
            write_slices(Path(ways[name][0]), stack)
        names = {name: (draws, "full", given) for name, (draws, given) in ways.items()}
        names["frames without noise"] = (None, "full", "screen")
        parts = {f"{what}: {name}{GIVEN.get(given, '')}": (ways[name][0], part, given) for part, what in PARTS.items()
                 for name, given in [("white", "screen"), *(("blue", given) for given in GIVEN), ("mask + R2", "screen")]}
        result = measure_all([*names.values(), *parts.values()], options.scenes, options.seeds, denoise, options.jobs)
        if not options.print:
            animation("penumbra", {"white noise": ways["white"], "mask + R2": ways["mask + R2"], "blue": ways["blue"]}, options.picture)
    blunt, sharp, clamped = HISTORIES
    places = [(sharp, NOISE), (clamped, NOISE), (blunt, MOVING), (sharp, MOVING), (clamped, MOVING), (clamped, AT_REST),
              (sharp, FLICKER), (clamped, FLICKER)]
    if denoise:
        places += [(DENOISED, MOVING), (DENOISED, FLICKER)]
    write_or_print(options, COMMAND, table(result, {code(name): task for name, task in names.items()}, places, "draws"))
    write_or_print(options, f"{COMMAND}: parts of the screen", table(
        result, {"every pixel: white": names["white"], "every pixel: blue": names["blue"], **parts},
        [(sharp, NOISE), (clamped, NOISE), (sharp, MOVING), (clamped, MOVING), (sharp, FLICKER)], "drawn in a frame"))
