// SPDX-License-Identifier: Apache-2.0
// The scene, the path tracer and the display of the image in GLSL ES 3.00, and the program that runs them. Load after package/texts.js.
"use strict";

const {BN_DRAW_GLSL, BN_PATH_GLSL, WORDS} = LIBBN_TEXTS;
const BN_SEED = [0x89025cc1, 0x910a2dec]; // the result of bn_sampler_seed() for seed 1
const BN_TABLE_WORDS = (() => {
  const bytes = Uint8Array.from(atob(WORDS), character => character.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Uint32Array.from({length: bytes.length / 4}, (_, i) => view.getUint32(4 * i, true));
})();

const VERSION = "#version 300 es\n";

// The whole image as one triangle.
const WHOLE_VERTEX = `${VERSION}
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }
`;

// Reads the words of the table from a texture 64 texels wide.
const DRAWS = `${VERSION}
precision highp float;
precision highp int;
precision highp usampler2D;
uniform usampler2D bn_words;
#define BN_WORD(i) texelFetch(bn_words, ivec2((i) & 63u, (i) >> 6u), 0).r
const uvec2 SEED = uvec2(${BN_SEED.map(word => `${word}u`)});
${BN_DRAW_GLSL}
${BN_PATH_GLSL}
`;

/* Renders one sample of each pixel and adds it to the sums, or to a moving average that follows surfaces as the camera moves. Both are
 * stored as float bits in an integer texture, which every WebGL 2 device can render to. An average is stored with the surface's distance
 * and its sample count.
 *
 * The scene is a room seen through its front wall, with a lamp on the ceiling, a block, a matte ball and a mirror ball. Each ray of a path has
 * one domain, bn_path_ray_domain(): numbers (0,1) give its direction, and (2,3) give the light sample at its end. */
const sampleFragment = type => `${DRAWS}
uniform usampler2D sums;
uniform uvec2 size;
uniform uint index, run;
uniform float weight; // weight of the newest sample in a settled moving average; 0: a sum
uniform vec3 camera, camera_before;
out uvec4 sum;

const vec3 ROOM = vec3(1.5, 2.0, 1.3); // half width, height, half depth
const vec3 LAMP_COLOUR = vec3(13.0, 11.5, 9.4);
const vec2 LAMP_AT = vec2(0.0, 0.05), LAMP_SIZE = vec2(0.4, 0.32); // x and z; half sizes
const vec4 BALL = vec4(0.62, 0.42, 0.1, 0.42), MIRROR = vec4(-0.4, 0.3, 0.7, 0.3);
const vec3 BLOCK_AT = vec3(-0.62, 0.6, -0.42), BLOCK_SIZE = vec3(0.33, 0.6, 0.33);
const vec2 BLOCK_TURN = vec2(0.9211, 0.3894); // cosine and sine
const float FAR = 1e20, NEAR = 1e-4;
const int MATTE = 0, LAMP = 1, GLOSS = 2;

struct surface {
  float distance;
  vec3 normal, colour;
  int kind;
};

// Keeps components away from zero, so that divisions are safe.
vec3 divisor(vec3 v) { return mix(v, vec3(1e-7), lessThan(abs(v), vec3(1e-7))); }

float to_ball(vec3 from, vec3 to, vec4 ball) {
  vec3 middle = ball.xyz - from;
  float along = dot(middle, to);
  vec3 across = middle - along * to;
  float inside = ball.w * ball.w - dot(across, across);
  if (inside < 0.0) return FAR;
  float distance = along - sqrt(inside);
  return distance > NEAR ? distance : FAR;
}

vec3 into_block(vec3 v) { return vec3(BLOCK_TURN.x * v.x + BLOCK_TURN.y * v.z, v.y, BLOCK_TURN.x * v.z - BLOCK_TURN.y * v.x); }
vec3 out_of_block(vec3 v) { return vec3(BLOCK_TURN.x * v.x - BLOCK_TURN.y * v.z, v.y, BLOCK_TURN.x * v.z + BLOCK_TURN.y * v.x); }

float to_block(vec3 from, vec3 to, out vec3 normal) {
  vec3 origin = into_block(from - BLOCK_AT), direction = divisor(into_block(to));
  vec3 middle = -origin / direction, half_way = BLOCK_SIZE / abs(direction);
  vec3 enter = middle - half_way, leave = middle + half_way;
  float first = max(enter.x, max(enter.y, enter.z));
  normal = -sign(direction) * vec3(equal(enter, vec3(first)));
  return first > NEAR && first < min(leave.x, min(leave.y, leave.z)) ? first : FAR;
}

surface room(vec3 from, vec3 to) {
  vec3 direction = divisor(to);
  vec3 walls = vec3(direction.x > 0.0 ? ROOM.x : -ROOM.x, direction.y > 0.0 ? ROOM.y : 0.0, direction.z > 0.0 ? ROOM.z : -ROOM.z);
  vec3 distances = (walls - from) / direction;
  surface s = surface(min(distances.x, min(distances.y, distances.z)), vec3(0.0), vec3(0.62, 0.6, 0.57), MATTE);
  vec3 at = from + to * s.distance;
  if (s.distance == distances.z) {
    s.normal = vec3(0.0, 0.0, -sign(to.z));
  } else if (s.distance == distances.x) {
    s.normal = vec3(-sign(to.x), 0.0, 0.0);
    s.colour = to.x > 0.0 ? vec3(0.12, 0.3, 0.5) : vec3(0.56, 0.18, 0.08);
  } else {
    s.normal = vec3(0.0, -sign(to.y), 0.0);
    if (to.y > 0.0 && all(lessThan(abs(at.xz - LAMP_AT), LAMP_SIZE))) s.kind = LAMP;
  }
  return s;
}

surface hit(vec3 from, vec3 to) {
  surface s = room(from, to);
  vec3 normal;
  float distance = to_block(from, to, normal);
  if (distance < s.distance) s = surface(distance, out_of_block(normal), vec3(0.62, 0.6, 0.57), MATTE);
  distance = to_ball(from, to, BALL);
  if (distance < s.distance) s = surface(distance, (from + to * distance - BALL.xyz) / BALL.w, vec3(0.7, 0.52, 0.22), MATTE);
  distance = to_ball(from, to, MIRROR);
  if (distance < s.distance) s = surface(distance, (from + to * distance - MIRROR.xyz) / MIRROR.w, vec3(0.5, 0.75, 0.72), GLOSS);
  return s;
}

bool blocked(vec3 from, vec3 to, float distance) {
  vec3 normal;
  return min(to_block(from, to, normal), min(to_ball(from, to, BALL), to_ball(from, to, MIRROR))) < distance;
}

// Light from a point on the lamp, divided by pi.
vec3 light_from(vec3 at, vec3 normal, vec2 u) {
  vec2 on_lamp = LAMP_AT + (2.0 * u - 1.0) * LAMP_SIZE;
  vec3 way = vec3(on_lamp.x, ROOM.y, on_lamp.y) - at;
  float distance = length(way);
  vec3 to = way / distance;
  float cosines = max(dot(to, normal), 0.0) * max(to.y, 0.0);
  if (cosines == 0.0 || blocked(at, to, distance)) return vec3(0.0);
  return LAMP_COLOUR * (cosines * 4.0 * LAMP_SIZE.x * LAMP_SIZE.y / (3.14159265 * distance * distance));
}

// A cosine-weighted direction above a surface, from the concentric map (Shirley and Chiu 1997), which is continuous.
vec3 scattered(vec3 normal, vec2 u) {
  vec2 v = 2.0 * u - 1.0, on_disc = vec2(0.0);
  if (abs(v.x) > abs(v.y)) {
    float angle = 0.78539816 * v.y / v.x;
    on_disc = v.x * vec2(cos(angle), sin(angle));
  } else if (v.y != 0.0) {
    float angle = 0.78539816 * v.x / v.y;
    on_disc = v.y * vec2(sin(angle), cos(angle));
  }
  vec3 side = normalize(abs(normal.y) > 0.5 ? vec3(normal.y, -normal.x, 0.0) : vec3(normal.z, 0.0, -normal.x));
  float up = sqrt(max(0.0, 1.0 - dot(on_disc, on_disc)));
  return on_disc.x * side + on_disc.y * cross(normal, side) + up * normal;
}

// A point's pixel position in the image, projected through the front wall, which fills the image for every camera.
vec2 on_screen(vec3 from, vec3 point) {
  vec3 at = from + (point - from) * ((ROOM.z - from.z) / (point.z - from.z));
  return 0.5 * (vec2(at.x / ROOM.x, 2.0 * at.y / ROOM.y - 1.0) + 1.0) * vec2(size);
}

// The previous average at the same surface, from the four surrounding pixels that show it, and its sample count: 0 if none of them do.
vec3 history(vec2 at, float distance, out float count) {
  ivec2 low = ivec2(floor(at - 0.5)), last = ivec2(size) - 1;
  vec2 part = at - 0.5 - vec2(low);
  vec3 light = vec3(0.0);
  float share = 0.0;
  count = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 step = ivec2(i & 1, i >> 1), there = low + step;
    uvec4 texel = texelFetch(sums, clamp(there, ivec2(0), last), 0);
    vec2 kept = unpackHalf2x16(texel.a), near = mix(1.0 - part, part, vec2(step));
    bool same = clamp(there, ivec2(0), last) == there && abs(kept.x - distance) < 0.03 * distance;
    float by = same ? near.x * near.y : 0.0;
    light += by * uintBitsToFloat(texel.rgb);
    count += by * kept.y;
    share += by;
  }
  count = share > 0.05 ? count / share : 0.0;
  return light / max(share, 1e-6);
}

vec3 light_along(bn_path path, out vec3 first, out vec2 place) {
  vec4 u = bn_draw_${type}_4d(SEED, path.x, path.y, path.index, bn_path_ray_domain(path, 0u));
  vec2 on_film = (2.0 * (vec2(path.x, path.y) + u.xy) - vec2(size)) / vec2(size);
  vec3 from = camera, to = normalize(vec3(on_film.x * ROOM.x, 0.5 * (on_film.y + 1.0) * ROOM.y, ROOM.z) - camera);
  place = u.xy;
  vec3 light = vec3(0.0), weight = vec3(1.0);
  bool sees_lamp = true; // from the camera, also in the mirror; caustics are omitted because their fireflies would hide everything else
  for (uint ray = 1u; ray <= 4u; ++ray) {
    surface s = hit(from, to);
    if (ray == 1u) first = from + to * s.distance;
    if (s.kind == LAMP) {
      if (sees_lamp) light += weight * LAMP_COLOUR;
      break;
    }
    weight *= s.colour;
    from += to * s.distance + s.normal * 1e-3;
    if (s.kind == MATTE) {
      light += weight * light_from(from, s.normal, u.zw);
      sees_lamp = false;
    }
    if (ray == 4u) break;
    u = bn_draw_${type}_4d(SEED, path.x, path.y, path.index, bn_path_ray_domain(path, ray));
    to = s.kind == GLOSS ? reflect(to, s.normal) : scattered(s.normal, u.xy);
  }
  return light;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  bn_path path = bn_path_start(uint(at.x), uint(at.y), index, run);
  vec3 first;
  vec2 place;
  vec3 light = light_along(path, first, place);
  float count = 0.0;
  if (weight == 0.0) {
    if (index > 0u) light += uintBitsToFloat(texelFetch(sums, at, 0).rgb);
  } else if (index > 0u) {
    vec2 was = vec2(at) + 0.5 + on_screen(camera_before, first) - on_screen(camera, first);
    vec3 before = history(was, distance(camera_before, first), count);
    light = mix(before, light, max(weight, 1.0 / (count + 1.0)));
  }
  sum = uvec4(floatBitsToUint(light), packHalf2x16(vec2(distance(camera, first), min(count + 1.0, 1000.0))));
}
`;

// ---- The displayed image: means, exposed and clipped, then blurred in linear light, then encoded for the screen

const BLUR = `${VERSION}
precision highp float;
precision highp int;
precision highp usampler2D;
uniform float sigma; // in pixels

vec3 shown(vec3 light) { return clamp(light, 0.0, 1.0); }

vec3 blurred(usampler2D image, ivec2 at, ivec2 step, float scale) {
  ivec2 last = textureSize(image, 0) - 1;
  int radius = int(ceil(3.0 * sigma));
  vec3 total = vec3(0.0);
  float weights = 0.0;
  for (int i = -radius; i <= radius; ++i) {
    float weight = radius == 0 ? 1.0 : exp(-0.5 * float(i * i) / (sigma * sigma));
    total += weight * shown(scale * uintBitsToFloat(texelFetch(image, clamp(at + i * step, ivec2(0), last), 0).rgb));
    weights += weight;
  }
  return total / weights;
}
`;

const BLUR_ROWS_FRAGMENT = `${BLUR}
uniform usampler2D sums;
uniform float scale; // divided by the number of samples
out uvec4 row;

void main() {
  row = uvec4(floatBitsToUint(blurred(sums, ivec2(gl_FragCoord.xy), ivec2(1, 0), scale)), 0u);
}
`;

const SHOW_FRAGMENT = `${BLUR}
uniform usampler2D left, right;
uniform int enlarged; // screen pixels per image pixel in each direction
uniform float split;  // in screen pixels
out vec4 colour;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) / enlarged;
  vec3 light = gl_FragCoord.x < split ? blurred(left, at, ivec2(0, 1), 1.0) : blurred(right, at, ivec2(0, 1), 1.0);
  colour = vec4(mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, greaterThan(light, vec3(0.0031308))), 1.0);
}
`;

// The difference of two images after a blur, for the error.
const DIFFERENCE_FRAGMENT = `${BLUR}
uniform usampler2D one, other;
out uvec4 difference;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 both = blurred(one, at, ivec2(0, 1), 1.0) - blurred(other, at, ivec2(0, 1), 1.0);
  difference = uvec4(floatBitsToUint(both), 0u);
}
`;

/* Sets the state that uploads of numbers depend on, in case the context was used for images before. */
function setUnpackState(gl) {
  gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
  for (const parameter of [gl.UNPACK_FLIP_Y_WEBGL, gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL]) gl.pixelStorei(parameter, false);
  for (const parameter of [gl.UNPACK_ROW_LENGTH, gl.UNPACK_SKIP_PIXELS, gl.UNPACK_SKIP_ROWS]) gl.pixelStorei(parameter, 0);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
}

/* A program that runs the fragment shader over the whole canvas. */
function compile(gl, fragment) {
  const program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, WHOLE_VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    const logs = gl.getAttachedShaders(program).map(shader => gl.getShaderInfoLog(shader));
    throw new Error(`a shader does not compile: ${[...logs, gl.getProgramInfoLog(program)].join(" ").trim()}`);
  }
  return program;
}
