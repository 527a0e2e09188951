// SPDX-License-Identifier: Apache-2.0
// Draws a million samples in WebGPU and WebGL 2, compares their hash with the library's, and times them. Load after tracer.js.
"use strict";

const SIDE = 1024; // draws along each side of the image
const COUNT = SIDE * SIDE;
const REPEATS = 8; // draws or fetches per thread when they are timed
const TEXELS = 256; // along each side of the fetched texture
const RIGHT = "c95c1816"; // of these draws in C
const element = id => document.getElementById(id);

/* Differs if one word differs or two are exchanged. */
function hashOf(words) {
  let h = 0;
  for (let i = 0; i < words.length; ++i) h = h + Math.imul(words[i], 2 * i + 1) | 0;
  return (h >>> 0).toString(16).padStart(8, "0");
}

const texels = () => Uint32Array.from({length: 4 * TEXELS * TEXELS}, (_, i) => Math.imul(i, 0x9e3779b1));

/* Nanoseconds per draw or fetch: the minimum of three runs of at least 30 ms. run(passes) draws and waits. */
async function nanoseconds(run) {
  await run(1); // compiles
  let passes = 1, best = Infinity;
  for (let runs = 0; runs < 3;) {
    const begun = performance.now();
    await run(passes);
    const took = performance.now() - begun;
    if (took < 30 && passes < 4096) passes *= 2;
    else best = Math.min(best, took / passes), ++runs;
  }
  return best * 1e6 / (COUNT * REPEATS);
}

// ---- WebGPU

const WGSL = `
@group(0) @binding(0) var<storage, read> bn_words: array<u32>;
@group(0) @binding(1) var<storage, read_write> results: array<vec4u>;
@group(0) @binding(2) var fetched: texture_2d<u32>;
${LIBBN_TEXTS.BN_DRAW_WGSL}
const SEED = vec2u(${BN_SEED.map(word => `${word}u`)});

fn sample(i: u32, more: u32) -> vec4u {
  return bn_draw_blue_bits(SEED, i % ${SIDE}u, i / ${SIDE}u, ((i * 0x9e3779b1u) >> 12u) + more, ((i * 0x85ebca6bu) >> 22u) << 22u);
}

fn texel(i: u32, more: u32) -> vec4u {
  return textureLoad(fetched, vec2u(i + more * 89u, i / ${SIDE}u + more * 55u) & vec2u(${TEXELS - 1}u), 0);
}

@compute @workgroup_size(64) fn check(@builtin(global_invocation_id) id: vec3u) { results[id.x] = sample(id.x, 0u); }

${["sample", "texel"].map(each => `
@compute @workgroup_size(64) fn time_${each}(@builtin(global_invocation_id) id: vec3u) {
  var sum = vec4u(0u);
  for (var more = 0u; more < ${REPEATS}u; more++) { sum ^= ${each}(id.x, more); }
  results[id.x] = sum;
}`).join("\n")}
`;

async function onWebGpu() {
  const adapter = navigator.gpu && await navigator.gpu.requestAdapter();
  if (!adapter) return null;
  const device = await adapter.requestDevice(), size = 16 * COUNT;
  device.pushErrorScope("validation");
  const words = device.createBuffer({size: BN_TABLE_WORDS.byteLength, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST});
  device.queue.writeBuffer(words, 0, BN_TABLE_WORDS);
  const results = device.createBuffer({size, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC});
  const copy = device.createBuffer({size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST});
  const texture = device.createTexture({size: [TEXELS, TEXELS], format: "rgba32uint",
                                        usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST});
  device.queue.writeTexture({texture}, texels(), {bytesPerRow: 16 * TEXELS}, [TEXELS, TEXELS]);
  const module = device.createShaderModule({code: WGSL});
  const resources = {check: [words, results], time_sample: [words, results], time_texel: [null, results, texture]};
  const run = async (entryPoint, passes) => {
    const pipeline = await device.createComputePipelineAsync({layout: "auto", compute: {module, entryPoint}});
    const entries = resources[entryPoint].flatMap((made, binding) =>
      made ? [{binding, resource: made === texture ? texture.createView() : {buffer: made}}] : []);
    const group = device.createBindGroup({layout: pipeline.getBindGroupLayout(0), entries});
    const encoder = device.createCommandEncoder(), pass = encoder.beginComputePass();
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, group);
    for (let i = 0; i < passes; ++i) pass.dispatchWorkgroups(COUNT / 64);
    pass.end();
    if (entryPoint === "check") encoder.copyBufferToBuffer(results, 0, copy, 0, size);
    device.queue.submit([encoder.finish()]);
    await device.queue.onSubmittedWorkDone();
  };
  await run("check", 1);
  const error = await device.popErrorScope();
  if (error) throw error;
  await copy.mapAsync(GPUMapMode.READ);
  const drawn = new Uint32Array(copy.getMappedRange()).slice();
  const {vendor, architecture, device: model, description} = adapter.info ?? {};
  return {drawn, name: [vendor, architecture, model, description].filter(Boolean).join(" ") || "unnamed adapter",
          draw: await nanoseconds(passes => run("time_sample", passes)), fetch: await nanoseconds(passes => run("time_texel", passes))};
}

// ---- WebGL 2

const CHECK_FRAGMENT = `${DRAWS}
uniform usampler2D fetched;
uniform uint repeats; // 0: the draw itself
uniform bool fetches;
out uvec4 result;

uvec4 draw(uint i, uint more) {
  bn_uint4 v = bn_draw_blue_bits(SEED, i % ${SIDE}u, i / ${SIDE}u, ((i * 0x9e3779b1u) >> 12u) + more, ((i * 0x85ebca6bu) >> 22u) << 22u);
  return uvec4(v.x, v.y, v.z, v.w);
}

uvec4 texel(uint i, uint more) {
  return texelFetch(fetched, ivec2(uvec2(i + more * 89u, i / ${SIDE}u + more * 55u) & uvec2(${TEXELS - 1}u)), 0);
}

void main() {
  uvec2 at = uvec2(gl_FragCoord.xy);
  uint i = at.x + at.y * ${SIDE}u;
  result = repeats == 0u ? draw(i, 0u) : uvec4(0u);
  if (fetches) for (uint more = 0u; more < repeats; ++more) result ^= texel(i, more);
  else for (uint more = 0u; more < repeats; ++more) result ^= draw(i, more);
}
`;

async function onWebGl2() {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return null;
  const program = compile(gl, CHECK_FRAGMENT), words = makeWords(gl), image = makeImage(gl, SIDE, SIDE), fetched = makeImage(gl, TEXELS, TEXELS);
  setUnpackState(gl);
  gl.bindTexture(gl.TEXTURE_2D, fetched.texture);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, TEXELS, TEXELS, gl.RGBA_INTEGER, gl.UNSIGNED_INT, texels());
  const read = side => {
    const out = new Uint32Array(4 * side * side);
    gl.readPixels(0, 0, side, side, gl.RGBA_INTEGER, gl.UNSIGNED_INT, out);
    return out;
  };
  const run = (fetches, repeats, passes) => {
    const uniforms = {bn_words: words, fetched, repeats: place => gl.uniform1ui(place, repeats), fetches: place => gl.uniform1i(place, fetches)};
    for (let i = 0; i < passes; ++i) draw(gl, program, image, SIDE, SIDE, uniforms);
  };
  run(false, 0, 1);
  const drawn = read(SIDE), names = gl.getExtension("WEBGL_debug_renderer_info");
  if (gl.getError()) throw new Error("WebGL reported an error");
  const time = fetches => nanoseconds(passes => (run(fetches, REPEATS, passes), read(1)));
  return {drawn, name: gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER), draw: await time(false), fetch: await time(true)};
}

// ---- The page

/* The class and text of an interface's line. The class is "right", "wrong", or "nothing" if the interface is not available. */
function verdict(name, result) {
  if (result === null) return ["nothing", `${name}: not in this browser${isSecureContext ? "" : ", or only over HTTPS or from disk"}.`];
  const hash = hashOf(result.drawn), right = hash === RIGHT;
  const bits = right ? `all bits match the library's (hash ${hash})` : `bits differ from the library's (hash ${hash}, not ${RIGHT})`;
  return [right ? "right" : "wrong", `${name}: ${result.name}: ${bits}; ${result.draw.toPrecision(3)} ns per draw of four numbers, ` +
          `${result.fetch.toPrecision(3)} ns per texture fetch.`];
}

async function check() {
  const report = [`libbn, table ${hashOf(BN_TABLE_WORDS)}`, navigator.userAgent];
  for (const [id, name, run] of [["webgpu", "WebGPU", onWebGpu], ["webgl2", "WebGL 2", onWebGl2]]) {
    let [is, text] = ["wrong", ""];
    try {
      [is, text] = verdict(name, await run());
    } catch (error) {
      text = `${name}: ${error.message ?? error}`;
    }
    element(id).className = `verdict ${is}`;
    element(id).textContent = text;
    report.push(text);
  }
  element("report").value = report.join("\n");
}

element("copy").addEventListener("click", () => {
  element("report").select();
  document.execCommand("copy"); // navigator.clipboard would need HTTPS
});
setTimeout(() => check()); // after the page has been shown
