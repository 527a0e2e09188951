# SPDX-License-Identifier: Apache-2.0
"""A folder of textures for engines: masks as PNG, EXR and KTX2, and the table of the draws with shaders that read it."""

from __future__ import annotations

import hashlib
import json
import shutil
import struct
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Optional, Sequence

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core, _files
from ._arguments import Progress
from ._masks import _BUILTIN_SIZES, anneal, builtin
from ._measure import dithering_error
from ._sampler import Sampler, tables

TEXTS = Path(__file__).parent / "pack"  # shaders and licences, installed with the package
FORMATS = ("png", "exr", "ktx2")
SIZES = tuple(size for size in _BUILTIN_SIZES if _core.builtin_mask_exists(size))
CHANNELS = (1, 2, 4)
SWEEPS = 1000
TABLE_WIDTH = 64
# Texts that are copied into a pack: installed beside this file, in the repository where they belong.
_SHADERS = ("bn_draw.glsl", "bn_path.glsl", "bn_draw.hlsl", "bn_path.hlsl")
# Formats of Vulkan, as KTX2 numbers them, by channels and bits: R8_UNORM, R16_UNORM, R8G8_UNORM ...
_VK_UNORM = {(1, 8): 9, (1, 16): 70, (2, 8): 16, (2, 16): 77, (4, 8): 37, (4, 16): 91}
_VK_R32_UINT = 98


def write(folder: Path, formats: Sequence[str], sizes: Sequence[int], seed: int, sweeps: int, version: str,
          progress: Optional[Progress] = None) -> dict[str, Any]:
    """Writes the pack and returns what its pack.json says. The folder is made, or is empty; after an error it is as before."""
    missing = [name for name in (*_SHADERS, "CC0-1.0.txt", "Apache-2.0.txt") if not (TEXTS / name).is_file()]
    if missing:
        raise FileNotFoundError(f"{TEXTS / missing[0]} is missing; install the package again")
    _files.pillow()  # for the contact sheet
    if "exr" in formats:
        _files.openexr()
    with _filled(folder) as beside:
        files: list[dict[str, Any]] = []
        sheet: dict[tuple[int, int], arguments.Ranks] = {}
        # Annealing takes nearly all of the time, in proportion to texels and sweeps.
        costs = {(size, channels): size * size * (1 if channels > 1 else 0.02) for size in sizes for channels in CHANNELS}
        done, total = 0.0, sum(costs.values())
        (beside / "masks").mkdir()
        for (size, channels), cost in costs.items():
            before = done

            def share(fraction: float) -> Any:
                return progress is not None and progress((before + fraction * cost) / total * 0.99)

            if channels == 1:
                ranks = builtin((size, size))
                share(1.0)
            else:
                ranks = anneal((size, size), seed=seed, channels=channels, sweeps=sweeps, progress=share)
            sheet[size, channels] = ranks
            made = f"annealed, seed {seed}, {sweeps} sweeps" if channels > 1 else "built-in"
            facts = {"size": size, "channels": channels, "made": made,
                     "dithering_error": [round(dithering_error(plane), 5) for plane in np.atleast_3d(ranks.T).T]}
            for name, bits in _write_mask(beside / "masks", ranks, formats, f"libbn {version}: {made}"):
                files.append({"file": f"masks/{name}", "bits": bits, **facts})
            done += cost
        _write_draws(beside / "draws", formats, seed, version)
        _contact_sheet(sheet, sizes).save(beside / "contact-sheet.png")
        (beside / "LICENSE.txt").write_text(_LICENCE + (TEXTS / "CC0-1.0.txt").read_text(encoding="utf-8"), encoding="utf-8")
        pack = {"version": version, "seed": seed, "sweeps": sweeps, "licence": "CC0-1.0, draws/*.glsl and *.hlsl Apache-2.0",
                "table_words": tables().size, "masks": files}
        (beside / "README.md").write_text(_readme(pack, sizes, formats), encoding="utf-8")
        hashes = {path.relative_to(beside).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
                  for path in sorted(beside.rglob("*")) if path.is_file()}
        pack["sha256"] = hashes
        (beside / "pack.json").write_text(json.dumps(pack, indent=1) + "\n", encoding="utf-8")
    arguments.report(progress, 1.0)
    return pack




@contextmanager
def _filled(folder: Path) -> Iterator[Path]:
    """Yields an empty folder, which becomes `folder` at the end, in one step; after an error nothing of it is left."""
    folder = folder.resolve()
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{folder} exists and is not a folder")
    if not folder.parent.is_dir():
        raise FileNotFoundError(f"the folder {folder.parent} does not exist")
    _refuse_others(folder)
    try:
        with tempfile.TemporaryDirectory(prefix=".bluenoise-", dir=folder.parent) as beside:
            pack = Path(beside, "pack")
            pack.mkdir()
            yield pack
            _refuse_others(folder)
            if folder.exists():
                folder.rmdir()
            pack.rename(folder)
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(folder)) from None


def _refuse_others(folder: Path) -> None:
    others = sorted(path.name for path in folder.iterdir()) if folder.exists() else []
    if others:
        raise FileExistsError(f"{folder} has other files, such as {others[0]}; give the name of a new folder, or of an empty one")


# ---- Masks


def _write_mask(folder: Path, ranks: arguments.Ranks, formats: Sequence[str], description: str) -> Iterator[tuple[str, int]]:
    """Writes a mask in every format. Yields names and bits."""
    size, channels = ranks.shape[-1], ranks.shape[0] if ranks.ndim == 3 else 1
    stem = f"mask_{size}_{channels}ch"
    for bits in (8, 16):
        name = f"{stem}_{bits}bit"
        if "png" in formats:
            _files.save_mask(folder / f"{name}.png", ".png", ranks, bits, description)
            yield f"{name}.png", bits
        if "ktx2" in formats:
            values = _files.quantized(ranks, bits)
            (folder / f"{name}.ktx2").write_bytes(ktx2(values, _VK_UNORM[channels, bits], description))
            yield f"{name}.ktx2", bits
    if "exr" in formats:
        _files.save_mask(folder / f"{stem}.exr", ".exr", ranks, 0, description)
        yield f"{stem}.exr", 32


# ---- KTX2


def ktx2(texels: npt.NDArray[Any], vk_format: int, writer: str) -> bytes:
    """A KTX 2.0 file of unsigned texels (height, width, channels), the first row on top, one level, not compressed. Khronos,
    "KTX File Format Specification", version 2.0, and "Data Format Specification", 1.3, sections 5 and 24."""
    height, width, channels = texels.shape
    bytes_of_channel = texels.itemsize
    texel_size = channels * bytes_of_channel
    integer = vk_format == _VK_R32_UINT
    samples = b""
    for channel in range(channels):
        number = 15 if channel == 3 else channel  # alpha has number 15
        bit = 8 * bytes_of_channel
        # Position, length less one, channel, four coordinates, and what the numbers 0 and 1 of the channel are.
        samples += struct.pack("<HBB4xII", channel * bit, bit - 1, number, 0, 1 if integer else 2**bit - 1)
    # Vendor and type 0, version 2 and size; RGBSDA, primaries of BT.709, linear, straight alpha; blocks of one texel.
    block = struct.pack("<IHHBBBB4BB7x", 0, 2, 24 + len(samples), 1, 1, 1, 0, 0, 0, 0, 0, texel_size) + samples
    described = struct.pack("<I", 4 + len(block)) + block
    pairs = b""
    for key, value in (("KTXorientation", "rd"), ("KTXwriter", writer)):
        pair = key.encode() + b"\0" + value.encode() + b"\0"
        pairs += struct.pack("<I", len(pair)) + pair + bytes(-len(pair) % 4)
    data = np.ascontiguousarray(texels, texels.dtype.newbyteorder("<")).tobytes()
    described_at = 12 + 36 + 32 + 24
    pairs_at = described_at + len(described)
    data_at = -(-(pairs_at + len(pairs)) // 8) * 8  # a multiple of the texel's size, 1 to 8 bytes, and of 4
    header = struct.pack("<9I", vk_format, bytes_of_channel, width, height, 0, 0, 1, 1, 0)
    index = struct.pack("<4I2Q", described_at, len(described), pairs_at, len(pairs), 0, 0)
    level = struct.pack("<3Q", data_at, len(data), len(data))
    file = b"\xabKTX 20\xbb\r\n\x1a\n" + header + index + level + described + pairs
    return file + bytes(data_at - len(file)) + data


# ---- Draws


def _write_draws(folder: Path, formats: Sequence[str], seed: int, version: str) -> None:
    folder.mkdir()
    words = tables()
    first, second = (f"0x{word:08x}u" for word in Sampler(seed=seed).seed_words())
    rows = np.zeros((-(-words.size // TABLE_WIDTH), TABLE_WIDTH), np.uint32)
    rows.reshape(-1)[: words.size] = words
    description = f"libbn {version}: bn_tables"
    if "ktx2" in formats:
        (folder / "draws.ktx2").write_bytes(ktx2(rows[:, :, None], _VK_R32_UINT, description))
    if "png" in formats:
        octets = rows.astype("<u4").view(np.uint8).reshape(*rows.shape, 4)
        (folder / "draws.png").write_bytes(_files.png(octets, _files.described(description)))
    for name in _SHADERS:
        shutil.copyfile(TEXTS / name, folder / name)
    shutil.copyfile(TEXTS / "Apache-2.0.txt", folder / "LICENSE.txt")
    (folder / "example.frag").write_text(_FRAGMENT % (first, second, seed), encoding="utf-8")
    (folder / "example.hlsl").write_text(_PIXEL % (first, second, seed), encoding="utf-8")


_FRAGMENT = """\
// SPDX-License-Identifier: Apache-2.0
// The first two numbers of sample `index` of each pixel. GLSL itself has no #include: paste the file in its place.
#version 330
uniform usampler2D bn_words; // draws.ktx2, R32_UINT, no filter
#define BN_WORD(i) texelFetch(bn_words, ivec2((i) & 63u, (i) >> 6u), 0).r
// With draws.png instead, RGBA8 without sRGB: uniform sampler2D bn_bytes, and
// #define BN_WORD(i) bn_word(i)
// uint bn_word(uint i) {
//     uvec4 b = uvec4(texelFetch(bn_bytes, ivec2(i & 63u, i >> 6u), 0) * 255.0 + 0.5);
//     return b.r | b.g << 8 | b.b << 16 | b.a << 24;
// }
#include "bn_draw.glsl"
const uvec2 seed = uvec2(%s, %s); // of %d, by bn_sampler_seed(); the table is the same for all seeds
uniform uint index;
out vec4 colour;

void main() {
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uint camera = bn_domain_child(0u, 0u); // one domain for each decision; bn_path.glsl numbers those of a path
    colour = vec4(bn_draw_blue_2d(seed, pixel.x, pixel.y, index, camera, 0u), 0.0, 1.0);
}
"""

_PIXEL = """\
// SPDX-License-Identifier: Apache-2.0
// The first two numbers of sample `index` of each pixel; shader model 5.0 and later.
Texture2D<uint> bn_words : register(t0); // draws.ktx2, R32_UINT
#define BN_WORD(i) bn_words.Load(int3((i) & 63u, (i) >> 6u, 0))
// With draws.png instead, RGBA8 without sRGB: Texture2D<float4> bn_bytes, and
// #define BN_WORD(i) bn_word(i)
// uint bn_word(uint i) {
//     uint4 b = uint4(bn_bytes.Load(int3(i & 63u, i >> 6u, 0)) * 255.0 + 0.5);
//     return b.r | b.g << 8 | b.b << 16 | b.a << 24;
// }
#include "bn_draw.hlsl"
static const uint2 seed = uint2(%s, %s); // of %d, by bn_sampler_seed(); the table is the same for all seeds
cbuffer frame : register(b0) { uint index; };

float4 main(float4 position : SV_Position) : SV_Target {
    uint2 pixel = uint2(position.xy);
    uint camera = bn_domain_child(0, 0); // one domain for each decision; bn_path.hlsl numbers those of a path
    return float4(bn_draw_blue_2d(seed, pixel.x, pixel.y, index, camera, 0), 0, 1);
}
"""

# ---- The sheet and the texts

_CELL, _GAP, _TOP, _LEFT = 256, 8, 24, 40
_COLUMNS = ("1 channel", "its darkest tenth", "2 channels as R, G", "4 channels: R, G, B", "4 channels: A", "A, darkest tenth")


def _contact_sheet(masks: dict[tuple[int, int], arguments.Ranks], sizes: Sequence[int]) -> Any:
    """A picture of all masks: a row for each size, tiled at one pixel a texel."""
    Image = _files.pillow()
    from PIL import ImageDraw

    sheet = Image.new("RGB", (_LEFT + len(_COLUMNS) * (_CELL + _GAP), _TOP + len(sizes) * (_CELL + _GAP)), "white")
    draw = ImageDraw.Draw(sheet)
    for column, text in enumerate(_COLUMNS):
        draw.text((_LEFT + column * (_CELL + _GAP), 6), text, fill="black")
    for row, size in enumerate(sizes):
        y = _TOP + row * (_CELL + _GAP)
        draw.text((6, y), str(size), fill="black")
        one, two, four = (_files.quantized(masks[size, channels], 8) for channels in CHANNELS)
        none = np.zeros_like(one)
        darkest = np.where(masks[size, 1] < size * size // 10, 0, 255).astype(np.uint8)[:, :, None]
        alpha = np.where(masks[size, 4][3] < size * size // 10, 0, 255).astype(np.uint8)[:, :, None]
        cells = (one, darkest, np.concatenate([two, none], axis=2), four[:, :, :3], four[:, :, 3:], alpha)
        for column, cell in enumerate(cells):
            times = _CELL // size
            texels = np.tile(np.broadcast_to(cell, (size, size, 3)), (times, times, 1)).astype(np.uint8)
            sheet.paste(Image.fromarray(texels), (_LEFT + column * (_CELL + _GAP), y))
    return sheet


_LICENCE = """\
The textures in this folder, masks and tables, were made by libbn. To the extent possible under law, their authors have dedicated
all copyright and related and neighbouring rights to them to the public domain worldwide under CC0 1.0 Universal, whose text follows.
The shaders in draws/ (.glsl, .hlsl, .frag) are Apache-2.0, see draws/LICENSE.txt.

SPDX-License-Identifier: CC0-1.0

"""


def _readme(pack: dict[str, Any], sizes: Sequence[int], formats: Sequence[str]) -> str:
    errors = {(each["size"], each["channels"]): each["dithering_error"] for each in pack["masks"]}
    rows = "".join(f"| {size} | " + " | ".join(", ".join(f"{error:.4f}" for error in errors[size, channels]) for channels in CHANNELS)
                   + " |\n" for size in sizes)
    return f"""\
# Blue-noise textures of libbn {pack["version"]}

![All masks](contact-sheet.png)

Made by `bluenoise textures`, seed {pack["seed"]}, {pack["sweeps"]} sweeps; `pack.json` has every file with its hash.

## masks/

`mask_SIZE_CHANNELSch_BITSbit` tiles seamlessly. Each channel holds each rank r from 0 to n - 1 once, n the number of texels, as
(r + 0.5) / n: as an integer of 8 or 16 bits, rounded down, or as 32-bit floats (.exr). With 8 bits, masks of more than 256 texels have
equal values. Channels of a mask are blue each and together, so that their texels differ as vectors, too.

| channels | .png | .exr | .ktx2 |
| ---: | --- | --- | --- |
| 1 | grey | Y | R8_UNORM, R16_UNORM |
| 2 | grey and alpha | R, G | R8G8_UNORM, R16G16_UNORM |
| 4 | RGBA | R, G, B, A | R8G8B8A8_UNORM, R16G16B16A16_UNORM |

Read them as data: linear, not sRGB; nearest texel, repeated; no mipmaps, no block compression, straight alpha. To dither to 8 bits, add
(mask - 0.5) / 255 to a channel before rounding.

A mask is enough for one number, or two, of one sample a frame: the start of a march, dithered transparency, an effect that is filtered
at once. Each frame adds a constant, modulo 1: 0.61803399 to one number; 0.75487767 and 0.56984029 to two, which come from two places
of the mask or from two channels. Use the draws below for more numbers of a pixel, for frames that are averaged and then filtered, for
a moving camera, for several samples of a pixel, and in path tracers. evidence/results/realtime.md of libbn has the errors of both.

The error E_1 of dithering after a blur of one texel, for each channel (white noise: 0.115):

| size | 1 channel | 2 channels | 4 channels |
| ---: | --- | --- | --- |
{rows}
## draws/

The tables of the sampler `blue`, {pack["table_words"]} words of 32 bits, row by row in a texture {TABLE_WIDTH} texels wide:
`draws.ktx2` as R32_UINT, `draws.png` as RGBA8 with the lowest byte in R. `bn_draw.glsl` and `bn_draw.hlsl` draw from it any number of
samples of any number of decisions for each pixel, the same bits as in C; `example.frag` and `example.hlsl` bind it. `bn_path.glsl` and
`bn_path.hlsl` number the decisions of a path. The tables are the same for every seed; the draws take a seed as two words.

## Licence

Textures CC0-1.0 (LICENSE.txt): use them without a notice. Shaders Apache-2.0 (draws/LICENSE.txt).
Formats in this pack: {", ".join(formats)}.
"""
