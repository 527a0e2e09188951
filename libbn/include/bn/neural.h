/* SPDX-License-Identifier: Apache-2.0
 * Masks from a neural network: whole masks of any size, and windows into an infinite plane that never repeats.
 * The conventions of bn.h apply. A library built with BN_NEURAL=OFF lacks these functions.
 *
 *     const bn_mask mask = bn_mask_u32(ranks, 640, 480);
 *     bn_neural *neural;
 *     if (bn_neural_open(NULL, &neural) == BN_SUCCESS) {
 *         bn_neural_mask(neural, &mask, seed, NULL, NULL);
 *         bn_neural_close(neural);
 *     }
 *
 * A small network turns white noise into blue noise; each texel depends only on the noise around it. Based on
 * Giunchi, Sztrajman and Steed, "Fast Blue-Noise Generation via Unsupervised Learning", 2022.
 *
 * ONNX RUNTIME
 *
 * The network runs in ONNX Runtime 1.17 or later, which is loaded when a network is opened. Tested with 1.19.2,
 * 1.21.1 and 1.31.1. You do not need ONNX Runtime to build or link libbn. bn_neural_open() looks for it:
 *
 *   1. at runtime_path, if that is not NULL;
 *   2. otherwise at the path in the BN_ONNXRUNTIME environment variable, if that is set. Programs that run
 *      with elevated privileges (set-user-ID and the like) ignore the variable;
 *   3. otherwise in the process itself, then as libonnxruntime.so.1 and libonnxruntime.so, their .dylib forms,
 *      or onnxruntime.dll.
 *
 * ONNX Runtime prints nothing. Some versions send telemetry unless the ORT_DISABLE_TELEMETRY environment
 * variable is set when they are loaded. If bn_neural_open() loads the library while the variable is unset, it
 * sets the variable to 1, which is unsafe while another thread reads the environment. In a multi-threaded
 * program, set the variable at startup; libbn then leaves the environment alone.
 *
 * GPU
 *
 * With the "cuda" provider, the network runs on the first NVIDIA GPU that CUDA finds. This requires an ONNX
 * Runtime with the CUDA execution provider, and the versions of CUDA and cuDNN it was built for. Noise and
 * ranks are still computed on the CPU, and all arguments reside in host memory. Tiles are up to 1024 x 1024
 * texels, so large windows and masks should gain the most, although this has not been measured. If the
 * provider or the GPU is missing, or cannot run the whole network, bn_neural_open() fails with RUNTIME. It
 * never falls back to the CPU; to use the CPU, open the network again without a provider.
 *
 * REPRODUCIBILITY
 *
 * Mask quality does not depend on the seed or the machine. Only the input noise is guaranteed to be
 * bit-identical everywhere. In practice the built-in single-channel network is also bit-identical on any CPU,
 * with any number of threads and for any window, because it uses only additions, subtractions,
 * multiplications and comparisons (ONNX Runtime 1.19.2, 1.21.1 and 1.31.1 agree). The two-channel network also
 * uses divisions and square roots, which 1.19.2 rounds differently from the other two. Bits can change if a
 * version of ONNX Runtime fuses operations, if a model uses other operations, or if the network runs on a GPU.
 * On a CPU, within one process, the number of threads and a window's extents change values by less than 1e-5;
 * on a GPU this bound is likely to hold but is not guaranteed. */
#ifndef BN_BN_NEURAL_H
#define BN_BN_NEURAL_H

/* Your warnings, such as -Wshadow, do not apply to this header unless you define BN_SHOW_WARNINGS. */
#if defined(__GNUC__) && !defined(BN_SHOW_WARNINGS)
#pragma GCC system_header
#endif

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
    /* The model: the path to a file, or the file's contents, which need not outlive the call. If both are
     * NULL (default), the built-in network is used; a library built with BN_SMALL_DATA does not include
     * it. */
    const char *model_path;
    const void *model;
    size_t model_size; /* size of model in bytes; 0 if it is NULL */
    /* The path to the ONNX Runtime library. NULL (default): search for it. */
    const char *runtime_path;
    /* Threads for each mask or window. 0 (default): bn_thread_count(), but at most four if a GPU runs the network
     * (they generate noise while the GPU works). */
    uint32_t threads;
    /* "cpu" (same as NULL, the default) or "cuda"; see GPU above. */
    const char *provider;
    /* Number of channels. For the built-in network: 1 (or 0, the default), or 2 for vector masks, whose
     * channels are jointly blue (nearby texels differ as vectors). For your own model: 0, or the number of
     * channels the model must have. */
    uint32_t channels;
} bn_neural_options;

BN_INLINE bn_neural_options bn_neural_options_default(void) {
    bn_neural_options options = {sizeof(bn_neural_options), NULL, NULL, 0, NULL, 0, NULL, 0};
    return options;
}

/* Opens a network. Takes up to a few tenths of a second, so open a network once and keep it. On failure,
 * *neural is set to NULL. Errors:
 *
 *   INVALID_ARGUMENT  neural is NULL, two models are given, a path is empty, the model does not have
 *                     the requested number of channels, or the provider's name is unknown
 *   IO                model_path cannot be read
 *   BAD_DATA          the model is damaged, larger than 64 MiB or not in the format below, or its
 *                     output is not finite
 *   UNSUPPORTED       the model has a different bn.version; this library has no built-in network; this
 *                     system cannot load libraries
 *   RUNTIME           ONNX Runtime was not found, is too old, lacks the provider, or failed; there
 *                     is no GPU, or it cannot run the whole model
 *   OUT_OF_MEMORY
 *
 * A model is code. ONNX Runtime runs it with the process's privileges; a model can use any amount of memory
 * and time, and can refer to other files. Open only models you trust, or sandbox the process.
 *
 * Model format. An ONNX file of at most 64 MiB with one input, `noise`, and one output, both float32. The
 * input has shape (1, 1, h + 2r, w + 2r) and is uniform in [0, 1). The output has shape (1, C, h, w), where C
 * is 1 to 16. The graph uses no padding. Metadata:
 *
 *   bn.version           1
 *   bn.receptive_radius  r, at most 256: the radius of the receptive field
 *   bn.align             h, w and the first texel's position must be multiples of this number, which
 *                        is at most 64 (1 for a network without strides). Callers may request any
 *                        extents
 *   bn.quantiles         optional, for outputs that are not uniform in [0, 1): 65 comma-separated
 *                        integers. The i-th is 2^24 times the i / 64 quantile of the outputs.
 *                        bn_neural_window() uses them to make values uniform
 *   bn.sparse_spacing    optional, from 1 to 10,000: the point spacing, in hundredths of a texel,
 *                        beyond which the network places points poorly. bn_neural_mask() reorders
 *                        the first and last ranks as bn_void_and_cluster() would: those whose
 *                        points are at least this far apart on average. Windows are not affected */
BN_API bn_result bn_neural_open(const bn_neural_options *options, bn_neural **neural);

/* Closes a network. NULL is allowed. */
BN_API void bn_neural_close(bn_neural *neural);

/* Returns C, the network's number of channels; 0 for NULL. */
BN_API uint32_t bn_neural_channels(const bn_neural *neural);

/* ---- Masks and windows */

/* Makes a 2-D mask with C channels and any extents. Quality is guaranteed at 16 x 16 texels and above. The
 * network runs in tiles. In addition to the ranks, the call needs up to 24 bytes per texel and channel, plus
 * a few megabytes per thread (tens of megabytes with a GPU). Reports progress at the start and before each
 * tile the calling thread works on; a tile takes a fraction of a second. The final ranking cannot be
 * cancelled. Errors: INVALID_ARGUMENT (a NULL pointer, a zero extent, or the wrong channels, depth or
 * rank_bits), OUT_OF_MEMORY, BAD_DATA (the network's output is not finite), RUNTIME, CANCELLED. */
BN_API bn_result bn_neural_mask(const bn_neural *neural, const bn_mask *mask, uint64_t seed,
                                bn_progress progress, void *user);

/* Computes a window into a seed's infinite plane: width x height texels, starting at (x0, y0). The results go
 * to values[C][height][width]; they are in [0, 1) and uniformly distributed over the plane. Overlapping
 * windows agree to within 1e-5. Coordinates range from -2^40 to 2^40. For progress and errors, see
 * bn_neural_mask(); also fails with SIZE_MISMATCH, and with INVALID_ARGUMENT for a window that extends past
 * that range. If the call fails after work has begun, the contents of values are undefined. */
BN_API bn_result bn_neural_window(const bn_neural *neural, int64_t x0, int64_t y0, uint32_t width,
                                  uint32_t height, uint64_t seed, float *values, size_t count,
                                  bn_progress progress, void *user);

/* Computes the network's input so that you can train a network or run it elsewhere. noise[height][width] is
 * white noise in [0, 1): a hash of the seed and the coordinates, which is bit-identical everywhere. A window
 * holds the network's output for the noise around it; a mask uses the noise that starts at (0, 0), wrapped
 * around at its edges. Errors: INVALID_ARGUMENT (noise is NULL, a zero extent, coordinates beyond +-2^41),
 * SIZE_MISMATCH, OUT_OF_MEMORY (extents exceed the address space). */
BN_API bn_result bn_neural_noise(int64_t x0, int64_t y0, uint32_t width, uint32_t height,
                                 uint64_t seed, float *noise, size_t count);

#ifdef __cplusplus
}
#endif

#undef BN_INLINE

#endif
