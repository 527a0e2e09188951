// SPDX-License-Identifier: Apache-2.0
// Runs a shader in WebGPU or WebGL 2 and returns its results, for test_browser.py.

const WIDTH = 4096; // of the result image, which contains one word per pixel

const bytes = text => Uint8Array.from(atob(text), character => character.charCodeAt(0)).buffer;
const words = text => new Uint32Array(bytes(text));
const floats = text => new Float32Array(bytes(text));

// Inputs are arrays, or {width, texels} for an integer texture. They use bindings 0, 1, ..., and the results use the next binding.
async function webgpu(code, inputs, size, threads) {
    const device = await (await navigator.gpu.requestAdapter()).requestDevice();
    device.pushErrorScope("validation");
    const buffer = (size, usage) => device.createBuffer({size, usage});
    const resource = data => {
        if (data.texels) {
            const extent = [data.width, data.texels.length / data.width];
            const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
            const texture = device.createTexture({size: extent, format: "r32uint", usage});
            device.queue.writeTexture({texture}, data.texels, {bytesPerRow: 4 * data.width}, extent);
            return texture.createView();
        }
        const made = buffer(data.byteLength, GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST);
        device.queue.writeBuffer(made, 0, data);
        return {buffer: made};
    };
    const results = buffer(size, GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC);
    const copy = buffer(size, GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST);
    const module = device.createShaderModule({code});
    const pipeline = device.createComputePipeline({layout: "auto", compute: {module, entryPoint: "main"}});
    const entries = [...inputs.map(resource), {buffer: results}].map((resource, binding) => ({binding, resource}));
    const encoder = device.createCommandEncoder();
    const pass = encoder.beginComputePass();
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, device.createBindGroup({layout: pipeline.getBindGroupLayout(0), entries}));
    pass.dispatchWorkgroups(Math.ceil(threads / 64));
    pass.end();
    encoder.copyBufferToBuffer(results, 0, copy, 0, size);
    device.queue.submit([encoder.finish()]);
    const error = await device.popErrorScope();
    if (error) throw error;
    await copy.mapAsync(GPUMapMode.READ);
    return new Uint32Array(copy.getMappedRange()).slice();
}

// Inputs are integer or float textures {name: {width, texels}}, whose last row may be incomplete.
function webgl(fragment, inputs, height) {
    const gl = document.createElement("canvas").getContext("webgl2");
    const program = gl.createProgram();
    const vertex = `#version 300 es
        void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }`;
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
        gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    gl.useProgram(program);
    const texture = (unit, width, height, texels) => {
        const made = gl.createTexture(), floats = texels instanceof Float32Array;
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, made);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
        let all = null;
        if (texels) {
            all = new texels.constructor(width * height);
            all.set(texels);
        }
        const [kind, format, type] = floats ? [gl.R32F, gl.RED, gl.FLOAT] : [gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT];
        gl.texImage2D(gl.TEXTURE_2D, 0, kind, width, height, 0, format, type, all);
        return made;
    };
    Object.entries(inputs).forEach(([name, {width, texels}], unit) => {
        texture(unit, width, Math.ceil(texels.length / width), texels);
        gl.uniform1i(gl.getUniformLocation(program, name), unit);
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    const picture = texture(Object.keys(inputs).length, WIDTH, height, null);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, picture, 0);
    gl.viewport(0, 0, WIDTH, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const pixels = new Uint32Array(4 * WIDTH * height);
    gl.readPixels(0, 0, WIDTH, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, pixels);
    if (gl.getError()) throw new Error("WebGL error");
    return Uint32Array.from({length: WIDTH * height}, (_, i) => pixels[4 * i]);
}
