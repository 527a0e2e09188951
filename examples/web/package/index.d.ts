// SPDX-License-Identifier: Apache-2.0
// The types of index.js: the source of the shader modules, the table they read, and seeds.

/**
 * The effect numbers of the decisions that have a role in the layout of paths. Leave out decisions that your renderer does not
 * make. All other effect numbers are independent keys.
 */
export interface Effects {
  /** `rand2`: the position in the pixel. */
  pixel?: number;
  /** `rand2`, or `rand3` for a lens with several blades. */
  lens?: number;
  /** `rand2`: the direction in which the path continues. */
  direction?: number;
  /** `rand2`: a point on a light. `rand3`: the light, then the point. */
  light?: number;
  /** `rand2`: a direction to the environment, in paths that sample either the environment or a light. */
  environment?: number;
  /** `rand1`: the choice between a light and the environment. Needs `light`. */
  choice?: number;
}

/** The GLSL ES 3.00 module. Put it after `#version` and before your code. Its table is the uniform `bn_table`, a texture. */
export function glsl(options?: { effects?: Effects }): string;

/** The WGSL module. Put it before or after your code. */
export function wgsl(options?: {
  effects?: Effects;
  /** Where the table is: in a storage buffer (default), or in a texture, for stages that have no buffer left. */
  table?: "buffer" | "texture";
  /** Default 0. */
  group?: number;
  /** Default 0. */
  binding?: number;
}): string;

/** The contents of the buffer, which are the same for all seeds, frames and pixels. */
export function tableWords(): Uint32Array;

/** A new texture in WebGL 2 that holds the table. Works in, and restores, any state of the context. */
export function tableTexture(gl: WebGL2RenderingContext): WebGLTexture;

/** The contents of the texture, R32UI (`r32uint`), TABLE_WIDTH x TABLE_HEIGHT texels, row-major. */
export function tableTexels(): Uint32Array;

/** Two words for `rngSeed` in the shader, from an integer modulo 2^64. Seeds give independent images. */
export function seedWords(seed?: number | bigint): Uint32Array;

export const TABLE_WIDTH: 64;
export const TABLE_HEIGHT: 186;
