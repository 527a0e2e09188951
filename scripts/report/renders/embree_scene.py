# SPDX-License-Identifier: Apache-2.0
"""The Cornell box of examples/pathtracer in the XML format of embree-tools.

The walls, blocks and colours equal those of scene_cornell(); the light is a point just under the middle of the lamp,
because these programs do not render the area lights of the file format. The shadows therefore differ, but the rays are
the same: at each surface one towards the light and one that continues the path.
"""

WHITE, RED, GREEN = (0.725, 0.71, 0.68), (0.63, 0.065, 0.05), (0.14, 0.45, 0.091)
TOP, BACK = 548.8, 559.2
LAMP = (213, 343, 227, 332)  # x0, x1, z0, z1
# The flux of the lamp, with radiance 17, 12, 4 over its area, in all directions.
INTENSITY = tuple(radiance * (LAMP[1] - LAMP[0]) * (LAMP[3] - LAMP[2]) / 4 for radiance in (17, 12, 4))
# A 25 mm sensor at a focal length of 35 mm: a vertical angle of 39.3 degrees.
CORNELL_VIEW = ("--vp", 278, 273, -800, "--vi", 278, 273, 0, "--vu", 0, 1, 0, "--fov", 39.3077)
BLOCKS = ((165, ((130, 65), (82, 225), (240, 272), (290, 114))),
          (330, ((423, 247), (265, 296), (314, 456), (472, 406))))


def quads():
    """[(colour, four corners)]."""
    x0, x1, z0, z1 = LAMP

    def ceiling(xa, xb, za, zb):
        return WHITE, ((xa, TOP, za), (xb, TOP, za), (xb, TOP, zb), (xa, TOP, zb))

    result = [ceiling(0, 556, 0, z0), ceiling(0, 556, z1, BACK), ceiling(0, x0, z0, z1), ceiling(x1, 556, z0, z1),
              (WHITE, ((552.8, 0, 0), (0, 0, 0), (0, 0, BACK), (549.6, 0, BACK))),
              (WHITE, ((549.6, 0, BACK), (0, 0, BACK), (0, TOP, BACK), (556, TOP, BACK))),
              (GREEN, ((0, 0, BACK), (0, 0, 0), (0, TOP, 0), (0, TOP, BACK))),
              (RED, ((552.8, 0, 0), (549.6, 0, BACK), (556, TOP, BACK), (556, TOP, 0)))]
    for height, feet in BLOCKS:
        result.append((WHITE, tuple((x, height, z) for x, z in feet)))
        for (ax, az), (bx, bz) in zip(feet, (*feet[1:], feet[0])):
            result.append((WHITE, ((ax, 0, az), (bx, 0, bz), (bx, height, bz), (ax, height, az))))
    return result


def cornell_xml():
    """The whole file: a triangle mesh for each colour, and a lamp."""
    x0, x1, z0, z1 = LAMP
    parts = ['<?xml version="1.0"?>\n<scene>\n']
    parts.append(f"<PointLight><AffineSpace>1 0 0 {(x0 + x1) / 2}  0 1 0 {TOP - 1}  0 0 1 {(z0 + z1) / 2}</AffineSpace>"
                 f"<I>{' '.join(f'{v:.9g}' for v in INTENSITY)}</I></PointLight>\n")
    for number, colour in enumerate((WHITE, RED, GREEN)):
        corners = [corner for own, quad in quads() if own == colour for corner in quad]
        triangles = [(4 * i + a, 4 * i + b, 4 * i + c) for i in range(len(corners) // 4) for a, b, c in ((0, 1, 2), (0, 2, 3))]
        parts.append(
            f'<TriangleMesh><positions>{" ".join(f"{v:.9g}" for corner in corners for v in corner)}</positions>'
            f'<triangles>{" ".join(str(v) for triangle in triangles for v in triangle)}</triangles>'
            f'<material id="{number}"><code>"Matte"</code><parameters><float3 name="reflectance">'
            f'{" ".join(map(str, colour))}</float3></parameters></material></TriangleMesh>\n')
    return "".join([*parts, "</scene>\n"])
