// SPDX-License-Identifier: Apache-2.0
// The types of three.js: random numbers for three-gpu-pathtracer's WebGPU renderer.
import type {Effects} from "./index.js";

/** Nodes for `WebGPUPathTracer.setRandom()`. `effects` are the package's effect numbers; seeds give independent images. */
export function randomGenerator(options?: {effects?: Effects; seed?: number | bigint}): object;
