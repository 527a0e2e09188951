// SPDX-License-Identifier: Apache-2.0
// Renders with the shaders: the sample sums of three samplers, and the image on the canvas.
"use strict";

const TYPES = ["white", "sobol", "blue"];
const EXPOSURE = 1.0;
const WEIGHT = 0.1; // weight of the newest sample in a moving average

/* The camera's position in a frame: at rest, or moving along a figure of eight. */
function cameraAt(mode, frame) {
  return mode === "camera" ? [0.5 * Math.sin(frame / 45), 1 + 0.2 * Math.sin(frame / 22.5), 4.6] : [0, 1, 4.6];
}

/* An integer texture. If `words` is passed, it holds them in rows of 64; otherwise it holds four words per pixel and can be rendered to. */
function makeImage(gl, width, height, words = null) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, words ? gl.R32UI : gl.RGBA32UI, width, height);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
  if (words) {
    const rows = new Uint32Array(width * height);
    rows.set(words);
    setUnpackState(gl);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RED_INTEGER, gl.UNSIGNED_INT, rows);
    return {texture, framebuffer: null};
  }
  const framebuffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
  return {texture, framebuffer};
}

const makeWords = (gl, words = BN_TABLE_WORDS) => makeImage(gl, 64, Math.ceil(words.length / 64), words);

/* Draws into an image, or on the canvas if the image is null. Uniforms are images, or functions of their location. */
function draw(gl, program, into, width, height, uniforms) {
  gl.useProgram(program);
  gl.bindFramebuffer(gl.FRAMEBUFFER, into && into.framebuffer);
  let unit = 0;
  for (const [name, value] of Object.entries(uniforms)) {
    const place = gl.getUniformLocation(program, name);
    if (typeof value === "function") {
      value(place);
    } else {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, value.texture);
      gl.uniform1i(place, unit++);
    }
  }
  gl.viewport(0, 0, width, height);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
}

/* The path tracer for one canvas. Throws if the browser cannot run it. */
function makeTracer(canvas) {
  const gl = canvas.getContext("webgl2", {alpha: false, antialias: false, depth: false});
  if (!gl) throw new Error("it needs WebGL 2, which this browser does not offer");
  const words = makeWords(gl);
  const samplers = {};
  for (const type of TYPES) samplers[type] = {program: compile(gl, sampleFragment(type)), sums: []};
  const blurRows = compile(gl, BLUR_ROWS_FRAGMENT), show = compile(gl, SHOW_FRAGMENT);
  const differ = compile(gl, DIFFERENCE_FRAGMENT);
  let rows = [];
  const float = value => place => gl.uniform1f(place, value);
  const int = value => place => gl.uniform1i(place, value);
  const uint = value => place => gl.uniform1ui(place, value);
  const point = value => place => gl.uniform3fv(place, value);

  const remove = images => {
    for (const {texture, framebuffer} of images) {
      gl.deleteTexture(texture);
      gl.deleteFramebuffer(framebuffer);
    }
  };
  /* Renders the next sample of each pixel. `sums` contains the current image and an image to draw into; the result has the same order. */
  const add = (program, sums, index, run, mode = "sum") => {
    draw(gl, program, sums[1], tracer.width, tracer.height, {
      bn_words: words, sums: sums[0], index: uint(index), run: uint(run), weight: float(mode === "sum" ? 0 : WEIGHT),
      camera: point(cameraAt(mode, index)), camera_before: point(cameraAt(mode, index - 1)),
      size: place => gl.uniform2ui(place, tracer.width, tracer.height),
    });
    sums.reverse();
  };
  const readWords = image => {
    const bits = new Uint32Array(4 * tracer.width * tracer.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, image.framebuffer);
    gl.readPixels(0, 0, tracer.width, tracer.height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, bits);
    return new Float32Array(bits.buffer);
  };

  const tracer = {
    gl, width: 0, height: 0, count: 0, run: 0, mode: "sum",

    resize(width, height) {
      const pair = before => {
        remove(before);
        return [makeImage(gl, width, height), makeImage(gl, width, height)];
      };
      for (const sampler of Object.values(samplers)) sampler.sums = pair(sampler.sums);
      rows = pair(rows);
      Object.assign(tracer, {width, height, count: 0});
    },

    /* Restarts with zero samples; each run uses different random numbers. `mode` selects the "sum" of all frames, a moving "average", or
     * an average with a moving "camera". In all modes the index continues across frames. */
    restart(run, mode = tracer.mode) {
      Object.assign(tracer, {run, mode, count: 0});
    },

    /* Renders one more sample of each pixel with each sampler. */
    sample() {
      for (const {program, sums} of Object.values(samplers)) add(program, sums, tracer.count, tracer.run, tracer.mode);
      ++tracer.count;
    },

    /* Shows the image of one sampler to the left of a column, and the image of another to its right. */
    show(left, right, split, sigma, enlarged) {
      const scale = EXPOSURE / (tracer.mode === "sum" ? Math.max(tracer.count, 1) : 1);
      [left, right].forEach((type, i) => draw(gl, blurRows, rows[i], tracer.width, tracer.height,
        {sums: samplers[type].sums[0], scale: float(scale), sigma: float(sigma)}));
      draw(gl, show, null, tracer.width * enlarged, tracer.height * enlarged,
        {left: rows[0], right: rows[1], sigma: float(sigma), split: float(split), enlarged: int(enlarged)});
    },

    /* The sums of one sampler, four floats per pixel, rows from the bottom up. */
    read(type) {
      return readWords(samplers[type].sums[0]);
    },

    /* Yields a sampler's error after 1, 2, 3 ... samples, as displayed and after a blur, from two independent images: they differ by
     * the error times the square root of two. */
    *errors(type, sigma) {
      const {program} = samplers[type], {width, height} = tracer;
      const pictures = [0, 1].map(() => [makeImage(gl, width, height), makeImage(gl, width, height)]);
      try {
        for (let count = 0; ; ++count) {
          pictures.forEach((sums, i) => {
            add(program, sums, count, 0x80000000 + 8 * tracer.run + 4 * i); // differs from the keys of displayed images and of their families
            draw(gl, blurRows, rows[i], width, height, {sums: sums[0], scale: float(EXPOSURE / (count + 1)), sigma: float(sigma)});
          });
          draw(gl, differ, pictures[0][1], width, height, {one: rows[0], other: rows[1], sigma: float(sigma)});
          const squares = readWords(pictures[0][1]).reduce((sum, value, i) => i % 4 === 3 ? sum : sum + value * value, 0);
          yield Math.sqrt(squares / (6 * width * height));
        }
      } finally {
        remove(pictures.flat());
      }
    },
  };
  return tracer;
}
