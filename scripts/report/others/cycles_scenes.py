# SPDX-License-Identifier: Apache-2.0
"""The scenes of `scripts/bench cycles`, in the XML of Cycles' stand-alone program: those in examples/ of its checkout, which are read
from there, and two of our own. Pictures are the middle of one that is ZOOM times as wide, as whole small pictures show mostly edges.
"""

import dataclasses
import math
import re
from pathlib import Path

from ..renders.renderer import RenderError

SIZE = (192, 144)
ZOOM = 3
FOV = math.pi / 4  # of Cycles' cameras

SPHERE = '<include src="examples/objects/sphere.xml"/>'
CUBE = '<include src="examples/objects/cube.xml"/>'


def surface(name, closure, **parameters):
    values = "".join(f' {key}="{value}"' for key, value in parameters.items())
    return (f'<shader name="{name}"><{closure} name="{name}_closure"{values}/>'
            f'<connect from="{name}_closure {"emission" if closure == "emission" else "bsdf"}" to="output surface"/></shader>')


def put(shader, shape, translate="0 0 0", scale="1 1 1"):
    return (f'<transform translate="{translate}"><transform scale="{scale}"><state interpolation="smooth" shader="{shader}">{shape}</state>'
            '</transform></transform>')


def square(y, half):
    return f'<mesh P="{-half} {y} {half}  {half} {y} {half}  {half} {y} {-half}  {-half} {y} {-half}" nverts="4" verts="0 1 2 3"/>'


def lamp(x, y, z, width, depth, strength):
    """A rectangle that shines down."""
    return (f'<state shader="lamp"><light light_type="area" size="1" strength="{strength} {strength} {strength}" sizeu="{width}" '
            f'sizev="{depth}" tfm="1 0 0 {x}  0 0 1 {y}  0 1 0 {z}"/></state>')


def camera(**parameters):
    values = "".join(f' {key}="{value}"' for key, value in parameters.items())
    return f'<transform translate="0 2 -6" rotate="20 1 0 0"><camera type="perspective"{values}/></transform>'


PENUMBRA = "\n".join((
    camera(), surface("lamp", "emission", color="1 1 1", strength="1"), surface("floor", "diffuse_bsdf", color="0.7 0.7 0.65"),
    surface("wood", "diffuse_bsdf", color="0.6 0.4 0.25"), put("floor", square(-1, 12)),
    put("wood", SPHERE, "-0.55 -0.65 0.3", "0.35 0.35 0.35"), put("wood", CUBE, "0.5 -0.7 0.9", "0.15 0.3 0.15"),
    put("wood", CUBE, "0.1 0.6 0.2", "0.8 0.03 0.06"), put("wood", CUBE, "-0.2 0.9 1", "0.05 0.03 1.2"),
    lamp(-1.5, 4, 1, 1.2, 0.6, 120), lamp(1.2, 3.5, -0.5, 0.5, 0.5, 60), lamp(0.5, 4, 3, 0.3, 1.5, 90)))
LENS = "\n".join((
    '<integrator caustics_reflective="false"/>',
    camera(aperturesize="0.15", focaldistance="6.3"), surface("lamp", "emission", color="1 1 1", strength="1"),
    '<shader name="floor"><checker_texture name="checker" scale="1.5" color1="0.8 0.8 0.8" color2="0.15 0.2 0.4"/>'
    '<diffuse_bsdf name="floor_closure"/><connect from="checker color" to="floor_closure color"/>'
    '<connect from="floor_closure bsdf" to="output surface"/></shader>',
    surface("steel", "glossy_bsdf", color="0.8 0.8 0.8", roughness="0.15"),
    surface("copper", "glossy_bsdf", color="0.9 0.55 0.35", roughness="0.35"), put("floor", square(-1, 12)),
    *(put("steel" if i % 2 else "copper", SPHERE, f"{-1.2 + 0.6 * i} -0.7 {-2.4 + 1.5 * i}", "0.3 0.3 0.3") for i in range(5)),
    lamp(-2, 4, 0, 1, 1, 150), lamp(2, 3, 3, 0.5, 2, 150),
    '<background><background name="bg" color="0.5 0.6 0.8" strength="0.4"/><connect from="bg background" to="output surface"/>'
    '</background>'))


@dataclasses.dataclass(frozen=True)
class Scene:
    what: str
    body: str = ""  # of our own; else examples/scene_NAME.xml


SCENES = {
    "penumbra": Scene("ours: soft shadows of three lamps", PENUMBRA),
    "lens": Scene("ours: depth of field, glossy spheres", LENS),
    "caustics": Scene("Cycles': glass, a point light"),
    "cube_surface": Scene("Cycles': a diffuse cube under an even sky"),
    "cube_volume": Scene("Cycles': a cube of varying density"),
    "monkey": Scene("Cycles': rough glass and metal under a sky"),
    "sphere_bump": Scene("Cycles': a bumpy diffuse sphere"),
    "world_volume": Scene("Cycles': fog with three lights"),
}


@dataclasses.dataclass(frozen=True)
class View:
    scene: str
    name: str = "middle"
    size: tuple = SIZE

    @property
    def label(self):
        return self.scene


def text(scene, checkout, integrator):
    """A scene's XML, its camera zoomed; `integrator`: attributes. It includes files from a folder `examples` beside it."""
    body = SCENES[scene].body
    if not body:
        try:
            body = (Path(checkout) / "examples" / f"scene_{scene}.xml").read_text(encoding="utf-8")
        except OSError as error:
            raise RenderError(f"cannot read {error.filename} ({error.strerror})") from None
        body = re.sub(r"<\?xml[^>]*>|</?cycles>", "", body)
        body = re.sub(r'src="(?:\./)?objects/', 'src="examples/objects/', body)
    fov = 2 * math.atan(math.tan(FOV / 2) / ZOOM)
    body = re.sub(r'\s*\bfov="[^"]*"', "", body)
    body = body.replace('type="perspective"', f'type="perspective" fov="{fov:.6f}"')
    settings = "".join(f' {name}="{value}"' for name, value in integrator.items())
    return f"<cycles>\n{body}\n<integrator{settings}/>\n</cycles>\n"
