// SPDX-License-Identifier: Apache-2.0
// Blue noise for path tracers in the browser: the source of a WGSL and a GLSL module, and the table they read.
// README.md documents it.
import "./texts.js";

const {BN_DRAW_GLSL, BN_DRAW_WGSL, BN_PATH_GLSL, BN_PATH_WGSL, RANDOM_GLSL, RANDOM_WGSL, WORDS} = globalThis.LIBBN_TEXTS;

const NO_EFFECT = 0xffffffff;
const ROLES = ["pixel", "lens", "direction", "light", "environment", "choice"];

export const TABLE_WIDTH = 64;
export const TABLE_HEIGHT = 186;

// The effect number for each role.
function effectNumbers(effects) {
  for (const [role, effect] of Object.entries(effects)) {
    if (!ROLES.includes(role)) throw new TypeError(`effects: no role "${role}"; there are ${ROLES.join(", ")}`);
    if (!Number.isInteger(effect) || effect < 0 || effect >= NO_EFFECT) {
      throw new RangeError(`effects.${role} is ${effect}, not an integer from 0 to 2^32 - 2`);
    }
  }
  const numbers = Object.values(effects);
  if (new Set(numbers).size < numbers.length) throw new RangeError("effects: two roles have the same number");
  if ("choice" in effects && !("light" in effects)) throw new TypeError("effects.choice needs effects.light");
  return ROLES.map(role => [`BN_EFFECT_${role.toUpperCase()}`, `${effects[role] ?? NO_EFFECT}u`]);
}

function known(options, names) {
  for (const name of Object.keys(options)) {
    if (!names.includes(name)) throw new TypeError(`no option "${name}"; there are ${names.join(", ")}`);
  }
}

export function glsl(options = {}) {
  known(options, ["effects"]);
  return [
    "uniform highp usampler2D bn_table;",
    "#define BN_WORD(i) texelFetch(bn_table, ivec2((i) & 63u, (i) >> 6u), 0).r",
    ...effectNumbers(options.effects ?? {}).map(([name, number]) => `#define ${name} ${number}`),
    BN_DRAW_GLSL, BN_PATH_GLSL, RANDOM_GLSL,
  ].join("\n");
}

export function wgsl(options = {}) {
  known(options, ["effects", "table", "group", "binding"]);
  const {table = "buffer", group = 0, binding = 0} = options;
  for (const [name, value] of Object.entries({group, binding})) {
    if (!Number.isInteger(value) || value < 0) throw new RangeError(`${name} is ${value}, not an integer from 0`);
  }
  if (table !== "buffer" && table !== "texture") throw new RangeError(`table is "${table}", not "buffer" or "texture"`);
  const at = `@group(${group}) @binding(${binding})`;
  const declaration = table === "buffer" ? `${at} var<storage, read> bn_words: array<u32>;` : `\
${at} var bn_table: texture_2d<u32>;
fn bn_word(i: u32) -> u32 {
    return textureLoad(bn_table, vec2u(i & 63u, i >> 6u), 0).r;
}`;
  const draw = table === "buffer" ? BN_DRAW_WGSL : BN_DRAW_WGSL.replace(/\bbn_words\[([^\]]*)\]/g, "bn_word($1)");
  return [
    declaration,
    ...effectNumbers(options.effects ?? {}).map(([name, number]) => `const ${name} = ${number};`),
    draw, BN_PATH_WGSL, RANDOM_WGSL,
  ].join("\n");
}

// libbn hashes the seed with SplitMix64's finaliser.
export function seedWords(seed = 0) {
  const mixed = (v, shift, factor) => BigInt.asUintN(64, (v ^ (v >> shift)) * factor);
  let v = BigInt.asUintN(64, BigInt(seed) + 0x9e3779b97f4a7c15n);
  v = mixed(v, 30n, 0xbf58476d1ce4e5b9n);
  v = mixed(v, 27n, 0x94d049bb133111ebn);
  v ^= v >> 31n;
  return Uint32Array.of(Number(v & 0xffffffffn), Number(v >> 32n));
}

export function tableWords() {
  const bytes = Uint8Array.from(atob(WORDS), character => character.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Uint32Array.from({length: bytes.length / 4}, (_, i) => view.getUint32(4 * i, true));
}

export function tableTexels() {
  const texels = new Uint32Array(TABLE_WIDTH * TABLE_HEIGHT);
  texels.set(tableWords());
  return texels;
}

// Uploads depend on the context's unpack parameters, which a page may have set for its images.
const UNPACK = {
  UNPACK_FLIP_Y_WEBGL: false, UNPACK_PREMULTIPLY_ALPHA_WEBGL: false, UNPACK_ALIGNMENT: 4, UNPACK_ROW_LENGTH: 0,
  UNPACK_SKIP_PIXELS: 0, UNPACK_SKIP_ROWS: 0,
};

export function tableTexture(gl) {
  const parameters = Object.entries(UNPACK).map(([name, plain]) => [gl[name], plain, gl.getParameter(gl[name])]);
  const buffer = gl.getParameter(gl.PIXEL_UNPACK_BUFFER_BINDING), bound = gl.getParameter(gl.TEXTURE_BINDING_2D);
  const texture = gl.createTexture();
  gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
  for (const [parameter, plain] of parameters) gl.pixelStorei(parameter, plain);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32UI, TABLE_WIDTH, TABLE_HEIGHT, 0, gl.RED_INTEGER, gl.UNSIGNED_INT, tableTexels());
  gl.bindTexture(gl.TEXTURE_2D, bound);
  for (const [parameter, , before] of parameters) gl.pixelStorei(parameter, before);
  gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, buffer);
  return texture;
}
