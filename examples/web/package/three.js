// SPDX-License-Identifier: Apache-2.0
// Random numbers for the WebGPU renderer of three-gpu-pathtracer: nodes for its setRandom(). README.md documents them.
import {DataTexture, RedIntegerFormat, UnsignedIntType} from "three/webgpu";
import {texture} from "three/tsl";
import {wgslTagCode, wgslTagFn} from "three-mesh-bvh/webgpu";
import {seedWords, tableTexels, TABLE_HEIGHT, TABLE_WIDTH, wgsl} from "./index.js";

export function randomGenerator({effects = {}, seed = 0} = {}) {
  const table = new DataTexture(tableTexels(), TABLE_WIDTH, TABLE_HEIGHT, RedIntegerFormat, UnsignedIntType);
  table.needsUpdate = true;
  // three.js declares and binds its textures, so its node takes the place of the module's declaration.
  const source = wgsl({effects, table: "texture"});
  const library = wgslTagCode(source.slice(source.indexOf("\n")).split("bn_table"), texture(table));
  const [low, high] = seedWords(seed);
  const draw = count => wgslTagFn`${[library]}
    fn bn_three_rand${count}(effect: u32) -> ${count === 1 ? "f32" : `vec${count}f`} {
        return rand${count}(effect);
    }`;
  return {
    rngInit: wgslTagFn`${[library]}
    fn bn_three_init(pixel: vec2u, pathIndex: u32, bounceIndex: u32) -> void {
        rngSeed(vec2u(${low}u, ${high}u));
        rngInit(pixel, pathIndex, bounceIndex);
    }`,
    rngNextBounce: wgslTagFn`${[library]}
    fn bn_three_next_bounce() -> void {
        rngNextBounce();
    }`,
    rand1: draw(1), rand2: draw(2), rand3: draw(3), rand4: draw(4),
  };
}
