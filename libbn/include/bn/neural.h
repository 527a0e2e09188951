/* SPDX-License-Identifier: Apache-2.0
 * Masks from a neural network: of any size in one pass, and windows of an endless plane that never repeats.
 * The conventions are those of bn.h. A library built with BN_NEURAL=OFF does not have this part.
 *
 *     const bn_mask mask = bn_mask_u32(ranks, 640, 480);
 *     bn_neural *neural;
 *     if (bn_neural_open(NULL, &neural) == BN_SUCCESS) {
 *         bn_neural_mask(neural, &mask, seed, NULL, NULL);
 *         bn_neural_close(neural);
 *     }
 *
 * A small network turns white noise into blue noise; each texel depends only on the noise around it. After
 * Giunchi, Sztrajman and Steed, "Fast Blue-Noise Generation via Unsupervised Learning", 2022.
 *
 * ONNX RUNTIME
 *
 * The network runs in ONNX Runtime 1.17 or later, which is loaded when a network is opened: you need it
 * neither to build nor to link. bn_neural_open() looks for it
 *
 *   1. at runtime_path, if that is not NULL;
 *   2. otherwise at the path in the environment variable BN_ONNXRUNTIME, if that is set. Programs that run with
 *      more rights than their user (set-user-ID and the like) ignore the variable;
 *   3. otherwise in the process itself, then as libonnxruntime.so.1 and libonnxruntime.so, their .dylib forms,
 *      or onnxruntime.dll.
 *
 * ONNX Runtime prints nothing. Some versions send telemetry unless the environment variable
 * ORT_DISABLE_TELEMETRY is set when they are loaded. If bn_neural_open() loads the library, it sets that
 * variable to 1 unless it is set already, which is not safe while another thread reads the environment. In a
 * program with threads, set the variable at startup; libbn then leaves the environment alone.
 *
 * GPU
 *
 * With the provider "cuda", the network runs on the first NVIDIA GPU that CUDA finds. This needs an ONNX
 * Runtime with the CUDA execution provider, and the versions of CUDA and cuDNN that it was built for. Noise
 * and ranks are made on the CPU, and all arguments are in main memory. Large windows and masks gain the most:
 * tiles have up to 1024 x 1024 texels. If the provider or the GPU is missing, or cannot run all of the
 * network, bn_neural_open() fails with RUNTIME. It never falls back to the CPU: to do that, open the network
 * again without a provider.
 *
 * REPRODUCIBILITY
 *
 * Every seed and machine gives masks of the same quality. Only the noise that goes in is promised to have the
 * same bits everywhere. In practice the built-in network of one channel gives the same bits on any CPU, with
 * any number of threads and for any window, because it uses only additions, subtractions, multiplications and
 * comparisons (ONNX Runtime 1.17.3 and 1.31.1 agree). The network of two channels also divides and takes
 * square roots, which these two versions round differently. A version that fuses operations, a GPU, or a
 * model with other operations can change bits. On a CPU, within one process, the number of threads and the
 * extents of a window change values by less than 1e-5; on a GPU that is likely, but not promised. */
#ifndef BN_BN_NEURAL_H
#define BN_BN_NEURAL_H

#include <bn/bn.h>

#ifdef BN_NO_NEURAL
#error "this libbn was built with BN_NEURAL=OFF"
#endif

#ifdef __cplusplus
extern "C" {
#endif

#ifdef __cplusplus
#define BN_INLINE inline
#else
#define BN_INLINE static inline
#endif

/* ---- Opening a network */

typedef struct bn_neural bn_neural;

typedef struct bn_neural_options {
    size_t struct_size; /* sizeof(bn_neural_options) */
    /* The model: a file, or the bytes of one, which are not kept. With neither (the default), the built-in
     * network; a library built with BN_SMALL_DATA has none. */
    const char *model_path;
    const void *model;
    size_t model_size; /* bytes of model; 0 when it is NULL */
    /* The ONNX Runtime library; NULL (default) searches for it. */
    const char *runtime_path;
    /* Threads that work on each mask or window; 0 (default): one per CPU, with a GPU at most four, which make
     * noise while it works. */
    uint32_t threads;
    /* "cpu" (the same as NULL, the default) or "cuda", as described under GPU
     * above. */
    const char *provider;
    /* The channels of the built-in network: 1 (or 0, the default), or 2 for vector masks, whose channels are
     * jointly blue. For a model of your own: 0, or the number of channels that it must have. */
    uint32_t channels;
} bn_neural_options;

BN_INLINE bn_neural_options bn_neural_options_default(void) {
    bn_neural_options options = {sizeof(bn_neural_options), NULL, NULL, 0, NULL, 0, NULL, 0};
    return options;
}

/* Opens a network. Takes up to a few tenths of a second, so open it once and keep it. On failure *neural is
 * NULL. Errors:
 *
 *   INVALID_ARGUMENT  neural is NULL, there are two models, a path is empty, the model does not have
 *                     the channels that the options name, or there is no provider of that name
 *   IO                model_path cannot be read
 *   BAD_DATA          the model is damaged, larger than 64 MiB, not of the format below, or gives
 *                     numbers that are not finite
 *   UNSUPPORTED       the model has another bn.version; this library has no built-in network; this
 *                     system cannot load libraries
 *   RUNTIME           ONNX Runtime was not found, is too old, lacks the provider, or failed; there
 *                     is no GPU, or it cannot run all of the model
 *   OUT_OF_MEMORY
 *
 * A model is code. ONNX Runtime runs it with the rights of the process: it can use any amount of memory and
 * time, and name other files. Open only models that you trust, or confine the process.
 *
 * Model format. An ONNX file of at most 64 MiB with one input, `noise`, and one output, both float32. The
 * input has shape (1, 1, h + 2r, w + 2r) and is uniform in [0, 1). The output has shape (1, C, h, w), with 1
 * to 16 channels. The graph pads nothing. Its metadata hold:
 *
 *   bn.version           1
 *   bn.receptive_radius  r, at most 256: the radius of the receptive field
 *   bn.align             h, w and the position of the first texel are multiples of this number, at
 *                        most 64; 1 for a network without strides. Callers may use any extents
 *   bn.quantiles         optional, for outputs that are not uniform in [0, 1): 65 integers with
 *                        commas between them. The i-th is 2^24 times the value below which i / 64
 *                        of the outputs lie. bn_neural_window() uses them to make values uniform
 *   bn.sparse_spacing    optional, from 1 to 10,000: a distance in hundredths of a texel beyond which
 *                        the network spaces points poorly. bn_neural_mask() reorders the first and
 *                        the last ranks itself, as many as have points at least this far apart on
 *                        average, the way bn_void_and_cluster() does. Windows are not affected */
BN_API bn_result bn_neural_open(const bn_neural_options *options, bn_neural **neural);

/* Closes a network. NULL is allowed. */
BN_API void bn_neural_close(bn_neural *neural);

/* The number of channels, C, that the network makes; 0 for NULL. */
BN_API uint32_t bn_neural_channels(const bn_neural *neural);

/* ---- Masks and windows */

/* Fills in a 2-D mask of any extents and of C channels. Quality is promised from 16 x 16 texels on. Works in
 * tiles: needs up to 24 bytes per texel and channel besides the ranks, and a few megabytes per thread, with a
 * GPU some tens. Progress is reported at the start, and before each tile that the calling thread works on,
 * which takes a fraction of a second. Ranking, after the last tile, cannot be cancelled. Errors:
 * INVALID_ARGUMENT (a NULL, a zero extent, other channels, a depth, rank_bits), OUT_OF_MEMORY, BAD_DATA (the network
 * gave numbers that are not finite), RUNTIME, CANCELLED. */
BN_API bn_result bn_neural_mask(const bn_neural *neural, const bn_mask *mask, uint64_t seed,
                                bn_progress progress, void *user);

/* Makes a window of width x height texels of the endless plane of a seed, its first texel at (x0, y0):
 * values[C][height][width] in [0, 1), uniform over the plane. Windows that overlap agree within 1e-5.
 * Coordinates run from -2^40 to 2^40. Reports progress and fails like bn_neural_mask(), also with
 * SIZE_MISMATCH, and with INVALID_ARGUMENT for a window that reaches beyond the plane. If it fails after the
 * work has begun, the contents of values are undefined. */
BN_API bn_result bn_neural_window(const bn_neural *neural, int64_t x0, int64_t y0, uint32_t width,
                                  uint32_t height, uint64_t seed, float *values, size_t count,
                                  bn_progress progress, void *user);

/* The white noise that goes into the network, for training one or running it elsewhere: noise[height][width]
 * in [0, 1), a hash of the seed and the coordinates, the same bits everywhere. A window contains the
 * network's output for the noise around it; a mask uses the noise from (0, 0), repeated with the mask's extents.
 * Errors: INVALID_ARGUMENT (noise NULL, a zero extent, coordinates beyond +-2^41), SIZE_MISMATCH,
 * OUT_OF_MEMORY (extents exceed the address space). */
BN_API bn_result bn_neural_noise(int64_t x0, int64_t y0, uint32_t width, uint32_t height,
                                 uint64_t seed, float *noise, size_t count);

#ifdef __cplusplus
}
#endif

#undef BN_INLINE

#endif
