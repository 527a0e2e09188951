# SPDX-License-Identifier: Apache-2.0
"""Makes the seeds in corpus/: small files of every kind that the path tracer's readers know, and refused_* ones.

Run it with the repository's Python: `.venv/bin/python tests/fuzz/make_corpus.py`; it needs the path tracer in build/.
"""

import io
import pathlib
import struct
import subprocess
import sys

import numpy as np
import OpenEXR
from PIL import Image

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "tests/pathtracer"))
from scene_files import FOUR, QUAD, SIX, Gltf, floor, over_floor, textured_floor  # noqa: E402

PICTURE = np.arange(5 * 7 * 3, dtype=np.uint8).reshape(5, 7, 3) * 2


def save(kind, name, content):
    path = HERE / "corpus" / kind / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def encoded(pixels, kind, mode=None, **options):
    stream = io.BytesIO()
    image = Image.fromarray(pixels)
    (image.convert(mode) if mode else image).save(stream, kind, **options)
    return stream.getvalue()


def lamps():
    g = over_floor(floor())
    g.use("KHR_materials_transmission")
    glow = g.material((1, 1, 1), emissiveFactor=[1, 0.5, 0.2], doubleSided=True)
    glass = {"KHR_materials_transmission": {"transmissionFactor": 1}}
    g.node(mesh=g.mesh(QUAD + np.float32(1), SIX, glow, NORMAL=np.zeros_like(QUAD) + np.float32([0, 1, 0])))
    g.quads([QUAD * 0.5], g.material((1, 1, 1), extensions=glass, pbr={"roughnessFactor": 0.0}), scale=[1, 2, 3])
    g.light("point", 2)
    g.light("spot", 2, light={"spot": {"outerConeAngle": 0.5}})
    return g


def sparse():
    g = Gltf()
    indices, values = g.view(np.uint16([0, 2]).tobytes()), g.view(np.float32([[0, 1, 0], [1, 1, 1]]).tobytes())
    sparse = {"count": 2, "indices": {"bufferView": indices, "componentType": 5123}, "values": {"bufferView": values}}
    g.node(mesh=g.mesh(g.accessor(QUAD, sparse=sparse), mode=5))
    g.node(mesh=g.mesh((QUAD * 127).astype(np.int8), SIX, mode=4), matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
    return g


def gltf():
    for name, g in {
        "textured": textured_floor(lambda g: g.texture(FOUR, wrapS=33071), alphaMode="MASK"),
        "lamps": lamps(),
        "sparse": sparse(),
    }.items():
        save("gltf", f"{name}.gltf", g.gltf())
        save("gltf", f"{name}.glb", g.glb())


def obj():
    square = "v 0 0 0\nv 1 0 0 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n"
    material = "newmtl m\nKd .5 .5 .5\nKs 1 1 1\nNs 20\nillum 2\nmap_Kd -o .1 .2 0 -s 2 2 1 t.tga\nmap_d t.tga\n"
    more = "newmtl g\nillum 7\nNi 1.5\nTf 1 .9 .8\nnewmtl l\nKe 3 3 3\nmap_Ke t.tga\nPr .4\nPm 1\nnorm t.tga\n"
    faces = "mtllib a.mtl\nusemtl m\nf 1/1/1 2/2/1 3/3/1 4\nusemtl l\ns 1\nf -4 -3 -2\nusemtl g\ng a b\no c\nf 1 2 4\nl 1 2\np 3\n"
    save("obj", "materials.obj", f"{square}{faces}\0{material}{more}".encode())
    save("obj", "plain.obj", f"# a comment\n{square}f 1 2 3 4\nf 1//1 3//1 4//1\n".encode())


def textures():
    palette = Image.fromarray(PICTURE).convert("P")
    stream = io.BytesIO()
    palette.save(stream, "PNG")
    save("texture", "palette.png", stream.getvalue())
    save("texture", "rgb.png", encoded(PICTURE, "PNG"))
    save("texture", "grey16.png", encoded(PICTURE[..., 0].astype(np.uint16) * 257, "PNG"))
    picture = encoded(PICTURE[:1, :, 0].astype(np.uint16) * 257, "PNG")
    save("texture", "long_chunk.png", picture[:-12] + struct.pack(">I", 1 << 30) + b"IDAT")
    save("texture", "rgb.jpg", encoded(PICTURE, "JPEG", quality=30))
    save("texture", "grey.jpg", encoded(PICTURE[..., 0], "JPEG", progressive=True))
    whole = encoded(PICTURE[..., 0], "JPEG", progressive=True)
    save("texture", "cut.jpg", whole[:-3])
    save("texture", "refused_cut.jpg", whole[: len(whole) // 2])  # within a table
    save("texture", "refused_cmyk.jpg", encoded(PICTURE, "JPEG", mode="CMYK", quality=30))
    save("texture", "rgb.bmp", encoded(PICTURE, "BMP"))
    save("texture", "rgb.tga", encoded(PICTURE, "TGA"))
    save("texture", "packed.tga", encoded(PICTURE, "TGA", mode="RGBA", compression="tga_rle"))


def masks():
    save("png_mask", "grey.png", encoded(PICTURE[..., 0], "PNG"))
    save("png_mask", "grey16.png", encoded(PICTURE[..., 0].astype(np.uint16) * 257, "PNG"))
    save("png_mask", "rgba.png", encoded(PICTURE, "PNG", mode="RGBA"))
    save("png_mask", "one_bit.png", encoded(PICTURE[..., 0], "PNG", mode="1"))


def exrs():
    def write(name, compression, values):
        path = HERE / "corpus/exr" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with OpenEXR.File({"compression": compression, "type": OpenEXR.scanlineimage}, {"RGB": values}) as file:
            file.write(str(path))

    values = np.linspace(0, 1, 4 * 8 * 3, dtype=np.float32).reshape(4, 8, 3)
    write("zip.exr", OpenEXR.ZIP_COMPRESSION, values)
    write("plain.exr", OpenEXR.NO_COMPRESSION, values.astype(np.float16))
    write("piz.exr", OpenEXR.PIZ_COMPRESSION, values.astype(np.float16))
    write("rle.exr", OpenEXR.RLE_COMPRESSION, values)
    picture = HERE / "corpus/exr/picture.exr"
    program = ROOT / "build/examples/pathtracer/pathtracer"
    crop = ["--size", "8x6", "--crop", "2,1,5,4", "--spp", "2"]
    subprocess.run([program, *crop, "--quiet", "-o", picture], check=True)
    picture.with_suffix(".png").unlink()


for make in (gltf, obj, textures, masks, exrs):
    make()
