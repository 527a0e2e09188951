/* SPDX-License-Identifier: Apache-2.0
 * libbn: blue noise for path tracers. This header is the manual of the library: samples whose error
 * is distributed as blue noise over the screen, dither masks, and measures of both. (bn_ and BN_
 * mean blue noise. OpenSSL's BN_ means big numbers; no name is in both.)
 *
 * Other parts have headers of their own: bn_path.h has the decisions of a path by name, where a
 * renderer starts, and bn.hpp the same for C++14. bn_draw.h has the draws as inline functions,
 * bn_choose.h makes choices with a number of a draw and keeps the rest of it, and neural.h makes
 * masks with a neural network.
 *
 *     bn_sampler sampler = bn_sampler_make(seed);
 *     float u[4];
 *     bn_sample_4d(&sampler, x, y, index, domain, u);
 *
 * CONVENTIONS
 *
 * Results. Every function that can fail returns a bn_result. The library prints nothing and never
 * ends the program. Unless a function says otherwise, a call that fails leaves its outputs
 * untouched.
 *
 * Options. A function that takes an options structure accepts NULL for the defaults. Otherwise
 * start from the matching bn_*_options_default(), which fills in struct_size, and change what you
 * need. A library accepts the longer structure of a newer header as long as the options that it does
 * not know are all zero; otherwise the result is BN_ERROR_UNSUPPORTED. Any other struct_size is
 * BN_ERROR_INVALID_ARGUMENT.
 *
 * Arrays. Masks and images are row-major, x fastest: texel (x, y, z) of a mask is
 * ranks[(z * height + y) * width + x]. Every array comes with its number of elements. A count that
 * differs from the product of the extents is BN_ERROR_SIZE_MISMATCH.
 *
 * Ranks. A mask holds each rank from 0 to count - 1 exactly once. It is toroidal: it tiles the
 * plane without seams.
 *
 * Extents. A zero extent is BN_ERROR_INVALID_ARGUMENT. A mask of more than 2^31 - 1 texels is
 * BN_ERROR_OUT_OF_MEMORY, whatever memory there is.
 *
 * Threads. Any function may be called from any number of threads at once. Draws do not change their
 * sampler, nor masks the network that makes them.
 *
 * Reproducibility. The same seed gives the same bits on every machine, with every compiler and any
 * number of threads, whatever rounding mode, flush-to-zero or trap the program has set. The
 * neural network is the one exception; see neural.h. bn_mask_error(), bn_power_spectrum() and
 * bn_rank_to_float() from 2^27 ranks on round as the program has set. The bits of a sampler type stay
 * from version 0.1 on: improvements become new types. Masks of a new version may differ;
 * CHANGELOG.md says so. */
#ifndef BN_BN_H
#define BN_BN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this header. The build files read it from here. */
#define BN_VERSION_MAJOR 0
#define BN_VERSION_MINOR 1
#define BN_VERSION_PATCH 0

#if defined(BN_SHARED) && defined(_WIN32)
#if defined(BN_BUILDING)
#define BN_API __declspec(dllexport)
#else
#define BN_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define BN_API __attribute__((visibility("default")))
#else
#define BN_API
#endif

/* C++14 and later can compute samplers when they compile. */
#if defined(__cplusplus) &&                                                                        \
    (__cplusplus >= 201402L || (defined(_MSVC_LANG) && _MSVC_LANG >= 201402L))
#define BN_CONSTEXPR constexpr inline
#elif defined(__cplusplus)
#define BN_CONSTEXPR inline
#else
#define BN_CONSTEXPR static inline
#endif
/* In C++ with external linkage, so that inline functions of a program may call them. */
#ifdef __cplusplus
#define BN_INLINE inline
#else
#define BN_INLINE static inline
#endif

/* Of a function that only keeps its first argument, a pointer, whose array may be still to be filled. */
#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 11
#define BN_UNREAD __attribute__((access(none, 1)))
#else
#define BN_UNREAD
#endif

/* ---- Results */

typedef int32_t bn_result;

enum {
    BN_SUCCESS = 0,
    /* An argument is NULL, zero, not finite or out of range. */
    BN_ERROR_INVALID_ARGUMENT = 1,
    /* The count of an array is not the product of its extents. */
    BN_ERROR_SIZE_MISMATCH = 2,
    /* An allocation failed, or the data would be too large. */
    BN_ERROR_OUT_OF_MEMORY = 3,
    /* Ranks are not a permutation, there is a NaN among values, or a file is damaged or foreign. */
    BN_ERROR_BAD_DATA = 4,
    /* An option that only a newer version knows, or something this build does not offer. */
    BN_ERROR_UNSUPPORTED = 5,
    /* ONNX Runtime is missing or failed. */
    BN_ERROR_RUNTIME = 6,
    /* A file cannot be opened or read. */
    BN_ERROR_IO = 7,
    /* A progress callback asked to stop. */
    BN_ERROR_CANCELLED = 8
};

/* A short English description of a result. Never NULL, not even for an unknown result. */
BN_API const char *bn_result_string(bn_result result);

/* The version of the library that the program runs with, as "major.minor.patch". */
BN_API const char *bn_version_string(void);

/* A progress callback, or NULL, and what is passed to it are the last two arguments of long computations.
 * They call it at short intervals, on the thread that called the function, with the fraction done so
 * far, from 0 to 1. A non-zero return value cancels the computation, which then returns
 * BN_ERROR_CANCELLED. */
typedef int32_t (*bn_progress)(void *user, double fraction);

/* ---- Domains */

/* A domain identifies a decision along a path, or two that belong together, such as the direction
 * of a ray and the light sample where it ends. Over the sample indices of a pixel, the samples of a
 * domain are well distributed; over the screen, their error is blue noise. Samples of different
 * domains are independent, except within a family (see below). Derive domains along the call tree,
 * so that adding a decision in one place does not change the samples in another:
 *
 *     uint32_t frame    = bn_domain_child(BN_DOMAIN_ROOT, picture); // not of frames that are averaged
 *     uint32_t camera   = bn_domain_child(frame, 0);      // position in the pixel, first light
 *     uint32_t ray      = bn_domain_child(frame, bounce); // 1, 2, ...: direction, next light
 *     uint32_t roulette = bn_domain_child(ray, 0);
 *
 * A domain has four dimensions. (0, 1) and (2, 3) are the pairs to use for two-dimensional
 * decisions. Never use a dimension for two purposes.
 *
 * Families. The four children of a domain with keys 4 k to 4 k + 3 are a family. With BLUE, both
 * pairs of a domain are stratified together, in all four dimensions. So, nearly, are any two members
 * of a family. Use the two pairs of one domain, or members of one family, for decisions whose effects
 * multiply, such as the position in the pixel and the point on a light. A choice and then a pair, such
 * as a light and the point on it, are dimension 2 and (0, 1).
 *
 * Position in the pixel. Draw it from dimensions (0, 1), as (x, y), of a domain whose key is a
 * multiple of four. These dimensions are also well distributed along the rows and columns of the
 * image. That helps at edges parallel to its sides, where the error gathers on a line one pixel
 * wide. */

/* The root, from which all domains descend. */
#define BN_DOMAIN_ROOT 0u

/* The child of a domain: a hash of the domain and of key / 4, with key % 4 as the member of the
 * family. Any domain and any key are allowed. Takes about a nanosecond. As a hash has 30 bits, two
 * given families are one and the same with probability 2^-30. Among the 40 families of a path of depth
 * 16 that takes four single numbers, four pairs and two fours at each ray, that is one frame in a
 * million. With CUDA and HIP it is a function of bn_draw.h, for both sides. */
#if !defined(__CUDACC__) && !defined(__HIPCC__)
BN_API uint32_t bn_domain_child(uint32_t domain, uint32_t key);
#endif

/* ---- Masks as values */

/* A mask, a value that borrows its ranks: texel (x, y, z) of channel c is ranks[((c * depth + z) * height +
 * y) * width + x]. Each channel holds every rank from 0 to width * height * depth - 1 once. Functions that
 * make a mask fill in its ranks, which must be writable; all others only read them. */
typedef struct bn_mask {
    const void *ranks;
    uint32_t rank_bits; /* 16 (up to 65,536 texels) or 32 */
    uint32_t width, height;
    uint32_t depth, channels; /* 1, except for 3-D masks and vector masks */
} bn_mask;

/* A 2-D mask of one channel. */
BN_UNREAD BN_INLINE bn_mask bn_mask_u16(const uint16_t *ranks, uint32_t width, uint32_t height) {
    bn_mask mask = {ranks, 16, width, height, 1, 1};
    return mask;
}

BN_UNREAD BN_INLINE bn_mask bn_mask_u32(const uint32_t *ranks, uint32_t width, uint32_t height) {
    bn_mask mask = {ranks, 32, width, height, 1, 1};
    return mask;
}

/* ---- Samplers */

/* Increases with every change of the tables or of the values drawn from them; see Reproducibility. */
#define BN_DRAW_TABLE_VERSION 7u

typedef int32_t bn_sampler_type;

enum {
    /* The sampler to use. Progressive: it needs no sample count. The error is blue over the screen
     * in both pairs of every domain, without visible patterns. Over any aligned square of 2^s x 2^s
     * pixels, every aligned run of 2^m samples is a (0, m + 2 s, 2)-net in dimensions (0, 1) and in
     * (2, 3). In each pixel, every run of 4^m samples is a (0, m, 4)-net in base 4 in all four
     * dimensions. Blurred errors fall with nearly every sample, as each sample by itself is blue: the
     * pixels of 64 x 64 share the order of their samples. They share random digits as well, others
     * than the next 64 x 64, so errors do not accumulate across tiles. Over seeds and domains, such as
     * frames, each sample is uniform in all four dimensions. docs/blue.md has the construction. */
    BN_SAMPLER_BLUE = 0,
    /* Owen-scrambled Sobol' (0, 2)-sequences, padded, independent in each pixel: the usual choice
     * of renderers, as a baseline. Padded: dimensions (0, 1) and (2, 3) are two sequences in
     * unrelated orders, each well stratified, the two together not at all. */
    BN_SAMPLER_SOBOL = 1,
    /* Independent uniform random numbers: pcg4d (Jarzynski and Olano, "Hash Functions for GPU
     * Rendering", 2020) of pixel, index and domain. */
    BN_SAMPLER_WHITE = 2,
    /* One Sobol' sequence along a scrambled Morton curve over the pixels (Ahmed and Wonka,
     * "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of
     * Pixels", 2020). Good when exactly samples_per_pixel samples are taken, little better than
     * SOBOL when a pixel stops earlier. */
    BN_SAMPLER_ZORDER = 3,
    /* The usual use of a blue-noise texture, without its loss at higher counts: the mask gives the
     * first sample of every pixel, and a digitally shifted, scrambled Sobol' (0, 2)-sequence gives
     * the others. Blue at 1 sample, fading to SOBOL at 16. */
    BN_SAMPLER_MASK = 4
};

/* A sampler: a value of at most 48 bytes, to be copied, kept and shared between threads as one likes.
 * There is nothing to destroy. The fields are the library's: make it with one of the functions below. */
typedef struct bn_sampler {
    bn_sampler_type type;
    uint32_t log2_samples;    /* ZORDER: of the block of samples that every pixel owns */
    uint32_t seed[2];         /* hashed; see bn_sampler_seed() */
    const void *mask;         /* MASK: ranks, or NULL for the built-in mask */
    uint64_t mask_scale;      /* 2^63 over the number of ranks, rounded up */
    uint32_t mask_low_digits; /* the digits finer than ranks */
    uint32_t mask_width, mask_height, mask_rank_bits;
} bn_sampler;

#ifdef __clang__ /* which warns of casts in C++ */
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wold-style-cast"
#endif
/* A BLUE sampler. Different seeds give independent images. Cannot fail. */
BN_CONSTEXPR bn_sampler bn_sampler_make(uint64_t seed) {
    bn_sampler sampler = {BN_SAMPLER_BLUE, 8,  {0, 0}, NULL, (uint64_t)1 << 51,
                          0xfffffu,        64, 64,     16};
    /* The finaliser of SplitMix64 (Steele, Lea and Flood, 2014) with Stafford's variant 13. */
    uint64_t v = seed + 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    v ^= v >> 31;
    sampler.seed[0] = (uint32_t)v;
    sampler.seed[1] = (uint32_t)(v >> 32);
    return sampler;
}
#ifdef __clang__
#pragma clang diagnostic pop
#endif

/* The next three leave *sampler as it was if they fail. */

/* A sampler of any type. ZORDER is tuned for 256 samples, MASK uses the built-in 64 x 64 mask. Errors:
 * INVALID_ARGUMENT (sampler is NULL, there is no such type). */
BN_API bn_result bn_sampler_init(bn_sampler *sampler, bn_sampler_type type, uint64_t seed);

/* A ZORDER sampler, tuned for a number of samples per pixel: rounded up to a power of two, at most 2^16;
 * 0 means 256. Later indices remain valid. Errors: INVALID_ARGUMENT (sampler is NULL). */
BN_API bn_result bn_sampler_init_zorder(bn_sampler *sampler, uint32_t samples_per_pixel,
                                        uint64_t seed);

/* A MASK sampler from a 2-D mask of one channel, whose ranks must live and stay as they are for as long
 * as the sampler or a copy of it draws. Errors: INVALID_ARGUMENT (a NULL, a zero extent, a depth or
 * channels other than 1, rank_bits other than 16 or 32), BAD_DATA (the ranks are not a permutation),
 * OUT_OF_MEMORY (a bit per texel is needed for that check, or there are more than 2^31 - 1). */
BN_API bn_result bn_sampler_init_mask(bn_sampler *sampler, const bn_mask *mask, uint64_t seed);

/* ---- Draws by hand */

/* Draws sample number `index` of pixel (x, y) in a domain. The result depends on the arguments
 * alone, so the order of draws, threads, tiles, crops and restarts cannot change it. Coordinates
 * may be negative, and every index up to 2^32 - 1 gives a new sample. The sampler must be initialised.
 * Draws cannot fail, allocate nothing and take no locks.
 *
 * bn_sample_4d_u32() gives 32 random bits per dimension. The floats are out[i] = (u32[i] >> 8) *
 * 2^-24, always in [0, 1). The 1-D draw is dimension 0 of the 4-D draw. The 2-D draw is one pair of
 * dimensions, (0, 1) with pair 0 and (2, 3) with pair 1; only the lowest bit of `pair` counts. It never
 * takes longer than a 4-D draw. bn_draw.h has the same draws inline. */
BN_API float bn_sample_1d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                          uint32_t domain);
BN_API void bn_sample_2d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                         uint32_t domain, uint32_t pair, float out[2]);
BN_API void bn_sample_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                         uint32_t domain, float out[4]);
BN_API void bn_sample_4d_u32(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                             uint32_t domain, uint32_t out[4]);

/* Draws a block of samples, bit-equal to bn_sample_4d(): out[height][width][index_count][4], for
 * pixels x0 to x0 + width - 1, y0 to y0 + height - 1 and indices first_index to first_index +
 * index_count - 1. SOBOL and WHITE take about the time of a wavefront, BLUE with many indices
 * less: they share the work that depends on the pixel. Errors: INVALID_ARGUMENT (sampler or out is
 * NULL, an extent is zero, or the block runs past the last coordinate or index), SIZE_MISMATCH. */
BN_API bn_result bn_sample_block(const bn_sampler *sampler, int32_t x0, int32_t y0, uint32_t width,
                                 uint32_t height, uint32_t first_index, uint32_t index_count,
                                 uint32_t domain, float *out, size_t out_count);

/* The lanes of a wavefront, in any order. */
typedef struct bn_wavefront {
    size_t struct_size; /* sizeof(bn_wavefront) */
    size_t count;       /* of lanes: the elements of every array below */
    const int32_t *x, *y;
    /* Of each lane; NULL (default): shared_index and shared_domain are those of all lanes. */
    const uint32_t *index, *domain;
    uint32_t shared_index, shared_domain; /* defaults 0 and BN_DOMAIN_ROOT */
    /* NULL (default), or the ray of each lane, below 2^28: it draws from ray depth[i] of a path whose
     * domains begin at the lane's domain, as bn_path_ray() has it; the root is that of stream 0. */
    const uint32_t *depth;
    /* Where dimension d of lane i goes: out[d][i * stride]. NULL (default): it is not wanted. For
     * numbers side by side, u[count][4], out[d] is u + d and the stride 4. */
    float *out[4];
    size_t stride; /* default 1 */
} bn_wavefront;

BN_INLINE bn_wavefront bn_wavefront_default(void) {
    bn_wavefront wavefront = {
        sizeof(bn_wavefront),     0, NULL, NULL, NULL, NULL, 0, BN_DOMAIN_ROOT, NULL,
        {NULL, NULL, NULL, NULL}, 1};
    return wavefront;
}

/* Draws for all lanes of a wavefront, bit-equal to bn_sample_4d(). If only dimensions of one pair are
 * wanted, only that pair is drawn. Arrays need the alignment of their elements, 4 bytes, and must not
 * overlap the outputs. Allocates nothing and takes no locks. With AVX2, BLUE takes about half as long as
 * single draws, WHITE a third and SOBOL a quarter or less, and numbers side by side a nanosecond a
 * lane less than others. Other types take as long as single draws, and so do all on other CPUs and in
 * libraries compiled by MSVC or by GCC for Windows. Errors: INVALID_ARGUMENT (a NULL: sampler,
 * wavefront, x or y of lanes, or all of out; the stride is 0; struct_size was never set), UNSUPPORTED. */
BN_API bn_result bn_sample_wavefront(const bn_sampler *sampler, const bn_wavefront *wavefront);

/* ---- Drawing on a GPU (docs/shaders.md) */

/* The tables of BLUE, the same for every seed: *count words, 46.5 KiB, constant and always there.
 * bn_draw.glsl describes them. *version is BN_DRAW_TABLE_VERSION of the library. Either may be NULL. */
BN_API const uint32_t *bn_tables(size_t *count, uint32_t *version);

/* The seed of a sampler as shaders take it: two words. */
BN_INLINE void bn_sampler_seed(const bn_sampler *sampler, uint32_t seed[2]) {
    seed[0] = sampler->seed[0];
    seed[1] = sampler->seed[1];
}

/* ---- Making masks */

/* Three algorithms fill in a mask. Void-and-cluster makes good masks in milliseconds on one core.
 * Relaxation is nearly as good, takes less time and uses all cores. Annealing is slow and makes the
 * best ones. They call `progress` in C's default floating-point environment. Errors: INVALID_ARGUMENT
 * (a NULL, a zero extent, rank_bits other than 16 or 32 or too few, a depth or channels that the algorithm does
 * not make, an option out of range), OUT_OF_MEMORY, CANCELLED, UNSUPPORTED. */

typedef struct bn_void_and_cluster_options {
    size_t struct_size; /* sizeof(bn_void_and_cluster_options) */
    /* Standard deviation of the Gaussian in texels, from 0.25 to 16. Default 1.5, which looks best
     * from close up; from further away about 1.9 does. */
    double sigma;
    /* Share of texels in the initial pattern, above 0 and up to 0.5. Default 0.1. */
    double initial_fraction;
    uint64_t seed; /* default 0 */
} bn_void_and_cluster_options;

BN_INLINE bn_void_and_cluster_options bn_void_and_cluster_options_default(void) {
    bn_void_and_cluster_options options = {sizeof(bn_void_and_cluster_options), 1.5, 0.1, 0};
    return options;
}

/* Makes a mask of one channel, in two or three dimensions, by void-and-cluster (Ulichney, "The
 * void-and-cluster method for dither array generation", 1993). Quality equals that of the published
 * method, and is better at both ends of the grey scale. Runs on the calling thread. Takes about 0.2
 * microseconds and 14 bytes per texel (2-D, sigma 1.5); both grow almost linearly. */
BN_API bn_result bn_void_and_cluster(const bn_void_and_cluster_options *options,
                                     const bn_mask *mask, bn_progress progress,
                                     void *progress_user);

typedef struct bn_relax_options {
    size_t struct_size; /* sizeof(bn_relax_options) */
    /* 0 (default): one per processor. The result does not depend on it. */
    uint32_t threads;
    uint64_t seed; /* default 0 */
} bn_relax_options;

BN_INLINE bn_relax_options bn_relax_options_default(void) {
    bn_relax_options options = {sizeof(bn_relax_options), 0, 0};
    return options;
}

/* Makes a 2-D mask of one channel by parallel relaxation: the fastest way to a large mask, a little behind
 * void-and-cluster in quality. White noise takes 20 learned steps, which move all texels at once by
 * a weighted sum of clipped differences to their neighbours; what comes out is ranked. To refine a mask,
 * or for another blur, call bn_anneal(). */
BN_API bn_result bn_relax(const bn_relax_options *options, const bn_mask *mask,
                          bn_progress progress, void *progress_user);

typedef struct bn_anneal_options {
    size_t struct_size; /* sizeof(bn_anneal_options) */
    /* The viewing blur whose error is minimised, in texels, from 0.25 to 4. Default 1. Texels
     * interact by exp(-distance^2 / (4 sigma^2)). */
    double sigma;
    /* One channel only: a second, wider blur, from sigma to 4. Default 1.5. */
    double far_sigma;
    /* One channel only: the weight of the second blur's squared error relative to the first's; 0
     * for none. Default 1. */
    double far_weight;
    /* Several channels only: how close values must be to repel each other, from 0.01 to 100.
     * Default 1. */
    double value_sigma;
    /* Temperatures as a share of the most that the pairs of one texel can gain, with
     * 0 < end <= start <= 1; geometric in between. Defaults 4e-4 and 2e-6. */
    double start_temperature, end_temperature;
    uint32_t sweeps; /* trial swaps per texel; default 1000 */
    /* One channel only. 1 (default): order the first and the last ranks by void-and-cluster, since
     * their texels are too far apart for the blurs to reach. 0: leave them. */
    int32_t order_ends;
    /* 0 (default): start from void-and-cluster. 1: start from the contents of ranks. */
    int32_t start_from_ranks;
    uint64_t seed; /* default 0 */
} bn_anneal_options;

BN_INLINE bn_anneal_options bn_anneal_options_default(void) {
    bn_anneal_options options = {
        sizeof(bn_anneal_options), 1, 1.5, 1, 1, 4e-4, 2e-6, 1000, 1, 0, 0};
    return options;
}

/* Makes a 2-D mask of 1 to 4 channels by simulated annealing with swaps (Georgiev and Fajardo, "Blue-noise
 * dithered sampling", 2016): slow, and the best masks there are.
 *
 * With one channel it minimises E_sigma^2 + far_weight * E_far_sigma^2, where E is the error that
 * bn_mask_error() measures. A trial swap takes about 50 ns.
 *
 * With several, it minimises the sum over pairs of texels of exp(-distance^2 / (4 sigma^2)) *
 * exp(-|difference of values|^(channels / 2) / value_sigma^2), with values in [0, 1). A trial swap
 * takes about 1 microsecond.
 *
 * Also fails with BAD_DATA: the ranks to start from are not permutations. */
BN_API bn_result bn_anneal(const bn_anneal_options *options, const bn_mask *mask,
                           bn_progress progress, void *progress_user);

/* Ranks values: ranks[i] is the number of values less than values[i], plus the number of equal ones
 * that come before it. Takes linear time, and 16 bytes of scratch memory per value besides some tens
 * of kilobytes. Errors: INVALID_ARGUMENT (a NULL, a zero count), BAD_DATA (a NaN), OUT_OF_MEMORY
 * (also for more than 2^32 - 1 values). */
BN_API bn_result bn_ranks_from_values(const float *values, size_t count, uint32_t *ranks);

/* The value of a rank: (rank + 0.5) / count in double, rounded down to float, at most 1 - 2^-24. A
 * rank of count or more counts as count - 1. The value is 0 for a count of 0. */
BN_API float bn_rank_to_float(uint32_t rank, size_t count);

/* ---- Built-in masks */

/* Annealed for minutes, so better than masks made on the spot. CC0-1.0. A program linked with the
 * static library has them, 175 KB, only if it calls this function; samplers and
 * bn_dither() bring the 64 x 64 mask alone, 8 KB. */

/* The built-in mask of size x size texels, of 16 bits, in static storage. The sizes are 16, 32, 64, 128
 * and, unless the library was built with BN_SMALL_DATA, 256. Its ranks are NULL for any other size. */
BN_API bn_mask bn_builtin_mask(uint32_t size);

/* ---- Measuring masks */

/* Computes the dithering error E_sigma of a 2-D mask; lower is better. It is the root mean square,
 * over texels and the 64 thresholds t = (i + 0.5) / 64, of G_sigma * [m < t] - t. Here m is the
 * value (rank + 0.5) / count, and G_sigma is a toroidal Gaussian of sigma texels, applied as the
 * transfer function exp(-2 pi^2 sigma^2 f^2). White noise has 0.1152 at sigma 1. Errors:
 * those of bn_sampler_init_mask(), INVALID_ARGUMENT (sigma negative or not finite), CANCELLED. */
BN_API bn_result bn_mask_error(const bn_mask *mask, double sigma, double *error,
                               bn_progress progress, void *progress_user);

/* Computes the power spectrum of a 2-D mask. power[v * width + u] is the squared magnitude of the
 * discrete Fourier transform at frequency (u / width, v / height) cycles per texel, divided by the
 * sum of the squared deviations of the ranks from their mean. White noise has a power of 1
 * everywhere. Frequencies above 1/2 are negative: subtract 1. The constant term, power[0], is 0.
 * Errors: those of bn_sampler_init_mask(), SIZE_MISMATCH (count is not width * height), CANCELLED. */
BN_API bn_result bn_power_spectrum(const bn_mask *mask, float *power, size_t count,
                                   bn_progress progress, void *progress_user);

/* ---- Dithering */

typedef struct bn_dither_options {
    size_t struct_size; /* sizeof(bn_dither_options) */
    /* Evenly spaced output levels from 0 to 1; 2 (default) to 256. */
    uint32_t levels;
    /* 0 (default): keep the local mean of the values. 1: the values, and the output, are
     * sRGB-encoded; keep the local mean of the light they stand for. */
    int32_t srgb;
    /* 1 (default): give each channel the mask at a different offset, so that errors do not
     * correlate between channels. 0: give all channels the same one. */
    int32_t channel_offset;
    /* A 2-D mask of one channel, which is tiled; NULL (default) means the built-in 64 x 64 mask. */
    const bn_mask *mask;
} bn_dither_options;

BN_INLINE bn_dither_options bn_dither_options_default(void) {
    bn_dither_options options = {sizeof(bn_dither_options), 2, 0, 1, NULL};
    return options;
}

/* Dithers an image[height][width][channels] with values in [0, 1] to a few levels. A value v
 * becomes floor(v * (levels - 1) + t) / (levels - 1), where t is the mask's value (rank + 0.5) /
 * texels at that pixel. 0 stays 0 and 1 stays 1; values outside [0, 1] are clamped. With srgb, the
 * fraction of v * (levels - 1) is replaced by the one that preserves the light of v. `out` may be
 * the same array as `image`. Errors: INVALID_ARGUMENT (image or out is NULL, a zero extent, levels
 * out of range), those of bn_sampler_init_mask() for the mask, SIZE_MISMATCH, BAD_DATA (a NaN in the
 * image), OUT_OF_MEMORY, UNSUPPORTED. */
BN_API bn_result bn_dither(const bn_dither_options *options, const float *image, uint32_t width,
                           uint32_t height, uint32_t channels, float *out, size_t count);

#ifdef __cplusplus
}
#endif

#undef BN_CONSTEXPR
#undef BN_INLINE
#undef BN_UNREAD

#endif
