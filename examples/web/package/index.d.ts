// SPDX-License-Identifier: Apache-2.0

/**
 * The numbers that your renderer gives to decisions with a place in the layout of paths. Leave out those that it does not have;
 * all other numbers are keys of their own.
 */
export interface Effects {
  /** `rand2`: the position in the pixel. */
  pixel?: number;
  /** `rand2`, or `rand3` for a lens of several blades. */
  lens?: number;
  /** `rand2`: where the path goes on. */
  direction?: number;
  /** `rand2`: a point on a light. `rand3`: which light, then the point. */
  light?: number;
  /** `rand2`: a direction to the environment, in paths that ask either it or a light. */
  environment?: number;
  /** `rand1`: which of the two. Needs `light`. */
  choice?: number;
}

/** The GLSL ES 3.00 module, to be put behind `#version` and in front of yours. Its table is the uniform `bn_table`, a texture. */
export function glsl(options?: { effects?: Effects }): string;

/** The WGSL module, to be put in front of yours or behind it. */
export function wgsl(options?: {
  effects?: Effects;
  /** Where the table lies: in a storage buffer (default), or in a texture, where a stage has no buffer left. */
  table?: "buffer" | "texture";
  /** Default 0. */
  group?: number;
  /** Default 0. */
  binding?: number;
}): string;

/** The contents of the buffer: the same for all seeds, frames and pixels. */
export function tableWords(): Uint32Array;

/** The contents of the texture, R32UI (`r32uint`), TABLE_WIDTH x TABLE_HEIGHT texels, row by row. */
export function tableTexels(): Uint32Array;

/** Two words for `rngSeed` in the shader, from an integer, modulo 2^64. Seeds give independent images. */
export function seedWords(seed?: number | bigint): Uint32Array;

export const TABLE_WIDTH: 64;
export const TABLE_HEIGHT: 186;
