/* SPDX-License-Identifier: Apache-2.0
 * libbn supplies a path tracer with random numbers that make the errors of neighbouring pixels cancel. This
 * header declares the samplers and the functions that make, measure and apply dither masks.
 *
 * In a renderer, request numbers by purpose through bn_path.h or, in C++14, bn.hpp:
 *
 *     #include <bn/bn_path.h>
 *
 *     bn_sampler sampler = bn_sampler_make(seed);
 *     bn_path path = bn_path_start(x, y, index, 0); // sample `index` of pixel (x, y)
 *     bn_ray ray = bn_path_ray(&path, depth);
 *     float u[4];
 *     bn_ray_draw(&sampler, &ray, u); // u[0], u[1]: the direction; u[2], u[3]: a light at the ray's end
 *
 * To organise a renderer's decisions yourself, draw directly from domains. Call the function below, or
 * include bn_draw.h for an inline version:
 *
 *     bn_sample_4d(&sampler, x, y, index, bn_domain_child(BN_DOMAIN_ROOT, decision), u);
 *
 * bn_choose.h makes discrete choices and recycles the unused part of the random number. neural.h makes masks
 * with a neural network.
 *
 * CONVENTIONS
 *
 * Results. Every function that can fail returns a bn_result. A call that fails leaves its outputs untouched
 * unless documented otherwise. The library prints nothing and never terminates the program.
 *
 * Options. Pass NULL for the defaults. Otherwise start from bn_*_options_default(), which fills in
 * struct_size. A larger structure from a newer header is accepted as long as every option this library does
 * not know is zero; otherwise the result is UNSUPPORTED. Any other struct_size gives INVALID_ARGUMENT.
 *
 * Arrays. Images are row-major; x varies fastest. The element count passed with an array must equal the
 * product of its extents, or the result is SIZE_MISMATCH. A zero extent gives INVALID_ARGUMENT, and a mask of
 * more than 2^31 - 1 texels gives OUT_OF_MEMORY.
 *
 * Paths. File names are UTF-8 on Windows, whatever the program's code page. On other systems they are passed
 * on unchanged.
 *
 * Threads. You can call any function from any number of threads. Drawing does not modify the sampler.
 *
 * Reproducibility. The same seed gives bit-identical results on every machine, with any compiler and any
 * number of threads, whatever rounding mode, flush-to-zero mode or floating-point traps the program has set.
 * Exceptions: neural.h; bn_mask_error() and bn_power_spectrum(), which call the C math library;
 * bn_rank_to_float() for 2^27 ranks or more, which follows the program's rounding mode; and masks, dithering
 * and visible noise if you compile bn.c with Clang's -ffp-contract=fast, which ignores the source's pragmas
 * (GCC obeys them; CMake builds turn the option off). Starting with version 0.1, a sampler type's output never
 * changes, down to the bit: improvements become new sampler types. Masks may change between versions;
 * CHANGELOG.md says when. */
#ifndef BN_BN_H
#define BN_BN_H

/* Your warnings, such as -Wshadow, do not apply to this header unless you define BN_SHOW_WARNINGS. */
#if defined(__GNUC__) && !defined(BN_SHOW_WARNINGS)
#pragma GCC system_header
#endif

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

/* BN_CONSTEXPR is constexpr in C++14 and later. In C++, functions have external linkage so that a program's
 * own inline functions may call them. BN_UNREAD marks functions that do not read the array they are given. */
#ifdef __cplusplus
#define BN_INLINE inline
#else
#define BN_INLINE static inline
#endif
#if defined(__cplusplus) &&                                                                        \
    (__cplusplus >= 201402L || (defined(_MSVC_LANG) && _MSVC_LANG >= 201402L))
#define BN_CONSTEXPR constexpr inline
#else
#define BN_CONSTEXPR BN_INLINE
#endif
#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 11
#define BN_UNREAD __attribute__((access(none, 1)))
#else
#define BN_UNREAD
#endif

/* ---- Results */

typedef int32_t bn_result;

enum {
    BN_SUCCESS = 0,
    BN_ERROR_INVALID_ARGUMENT = 1, /* an argument is NULL, zero, not finite or out of range */
    BN_ERROR_SIZE_MISMATCH = 2,    /* an array's length is not the product of its extents */
    BN_ERROR_OUT_OF_MEMORY = 3,    /* an allocation failed, or the data would be too large */
    BN_ERROR_BAD_DATA = 4,         /* ranks that are not a permutation, a NaN, or a damaged file */
    BN_ERROR_UNSUPPORTED = 5,      /* not supported by this version or build */
    BN_ERROR_RUNTIME = 6,          /* ONNX Runtime is missing or failed */
    BN_ERROR_IO = 7,               /* a file cannot be opened or read */
    BN_ERROR_CANCELLED = 8         /* a progress callback asked to stop */
};

/* Return a short English description of any result, and the library's version at run time ("0.1.0"). */
BN_API const char *bn_result_string(bn_result result);
BN_API const char *bn_version_string(void);

/* Returns the number of CPUs that the process may use, at least 1: those of its CPU affinity and, on Linux, no
 * more than its control group's CPU limit, rounded up. Functions with a `threads` option use it if the option
 * is 0, up to a maximum of 64. On Linux, it reads a few small files. */
BN_API uint32_t bn_thread_count(void);

/* Long computations take a progress callback (or NULL) and a user pointer as their last two arguments. The
 * callback runs periodically on the calling thread and receives the fraction completed so far, from 0 to 1.
 * If it returns a non-zero value, the computation stops and returns CANCELLED. */
typedef int32_t (*bn_progress)(void *user, double fraction);

/* ---- Domains */

/* A domain identifies one decision along a path, or two that belong together, such as a ray's direction and
 * the light sample at its end. Within a pixel, a domain's samples are well distributed; across the image,
 * their error is blue noise. Samples from different domains are independent, except within a family. Derive
 * domains along the call tree so that adding a decision leaves every other decision's samples unchanged:
 *
 *     uint32_t camera   = bn_domain_child(BN_DOMAIN_ROOT, 0);      // pixel position, first light
 *     uint32_t ray      = bn_domain_child(BN_DOMAIN_ROOT, bounce); // 1, 2, ...: direction, next light
 *     uint32_t roulette = bn_domain_child(ray, 0);
 *
 * A domain has four dimensions. Use the pairs (0, 1) and (2, 3) for 2-D decisions, and use each dimension
 * only once. Paths in stream 0 use children of the root, so if you also use your own domains, put your paths
 * in other streams.
 *
 * Families. A domain's children with keys 4*k to 4*k + 3 form a family. BLUE stratifies a domain's four
 * dimensions together, and any two members of a family almost as well. Use a family for decisions whose
 * contributions multiply in the integrand, such as the pixel position and the point on a light. For a
 * discrete choice followed by a pair, such as a light and a point on it, use dimension 2, then (0, 1).
 *
 * Pixel position. Draw it from dimensions (0, 1) of a domain whose key is a multiple of four. The positions
 * are then also well distributed along the image's rows and columns, which helps at horizontal and vertical
 * edges. */

#define BN_DOMAIN_ROOT 0u /* the ancestor of all domains */

/* Returns a domain's child for a key; every domain and key is valid. The child is a hash of the domain and
 * key / 4; key % 4 selects the member of the family. Takes about a nanosecond. Two given families coincide
 * with probability 2^-30: for paths of 16 rays, a coincidence occurs in one frame in a million. In CUDA and
 * HIP, include bn_draw.h instead. */
#if !defined(__CUDACC__) && !defined(__HIPCC__)
BN_API uint32_t bn_domain_child(uint32_t domain, uint32_t key);
#endif

/* ---- Masks */

/* A mask does not own its ranks. Texel (x, y, z) of channel c is ranks[((c * depth + z) * height + y) * width
 * + x]. Each channel holds every rank from 0 to width * height * depth - 1 exactly once and tiles the plane
 * seamlessly. Functions that make a mask write to its ranks; all other functions only read them. */
typedef struct bn_mask {
    const void *ranks;
    uint32_t rank_bits; /* 16 (up to 65,536 texels) or 32 */
    uint32_t width, height;
    uint32_t depth, channels; /* 1, except for 3-D masks and vector masks */
} bn_mask;

/* Returns a single-channel 2-D mask. */
BN_UNREAD BN_INLINE bn_mask bn_mask_u16(const uint16_t *ranks, uint32_t width, uint32_t height) {
    bn_mask mask = {ranks, 16, width, height, 1, 1};
    return mask;
}

BN_UNREAD BN_INLINE bn_mask bn_mask_u32(const uint32_t *ranks, uint32_t width, uint32_t height) {
    bn_mask mask = {ranks, 32, width, height, 1, 1};
    return mask;
}

/* ---- Samplers */

/* Increases whenever the tables or the values drawn from them change. */
#define BN_DRAW_TABLE_VERSION 7u

typedef int32_t bn_sampler_type;
enum {
    /* The recommended sampler type. Progressive: it needs no sample count. For each pair of every domain, the
     * error across the image is blue noise without visible patterns. Over any aligned square of 2^s x 2^s
     * pixels, every aligned run of 2^m samples is a (0, m + 2 s, 2)-net in dimensions (0, 1) and in (2, 3).
     * Within a pixel, every aligned run of 4^m samples is a (0, m, 4)-net in base 4. Each sample index is
     * blue on its own, so the blurred error falls with nearly every sample. Errors do not repeat across the
     * image: each 64 x 64 pixel tile has its own sample order and scrambling (docs/blue.md). */
    BN_SAMPLER_BLUE = 0,
    /* Padded Owen-scrambled Sobol' (0, 2)-sequences, independent in each pixel: the usual baseline.
     * Dimensions (0, 1) and (2, 3) are each well stratified, but not stratified together. */
    BN_SAMPLER_SOBOL = 1,
    /* Independent random numbers: pcg4d (Jarzynski and Olano, 2020) hashes the pixel, index and domain. */
    BN_SAMPLER_WHITE = 2,
    /* One Sobol' sequence along a scrambled Morton curve over the pixels (Ahmed and Wonka, "Screen-Space
     * Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", 2020). Tuned
     * for a given sample count; a pixel that stops before reaching half that count has about the same error
     * as it would with SOBOL. */
    BN_SAMPLER_ZORDER = 3,
    /* A blue-noise mask supplies a pixel's first sample; a shifted, scrambled Sobol' sequence supplies the
     * rest. The error is blue noise at 1 sample, but in rendered images this type is no better than SOBOL at
     * 6 samples or more. */
    BN_SAMPLER_MASK = 4
};

/* A sampler is a plain value of at most 48 bytes. You can copy it, store it and share it between threads, and
 * there is nothing to destroy. Initialise it with one of the functions below. Its fields are private. */
typedef struct bn_sampler {
    bn_sampler_type type;
    uint32_t log2_samples;    /* ZORDER: log2 of the number of samples in each pixel's block */
    uint32_t seed[2];         /* hashed; see bn_sampler_seed() */
    const void *mask;         /* MASK: ranks, or NULL for the built-in mask */
    uint64_t mask_scale;      /* 2^63 divided by the number of ranks, rounded up */
    uint32_t mask_low_digits; /* the binary digits finer than the ranks */
    uint32_t mask_width, mask_height, mask_rank_bits;
} bn_sampler;

/* Returns a BLUE sampler. Different seeds give independent images. Cannot fail. */
BN_CONSTEXPR bn_sampler bn_sampler_make(uint64_t seed) {
    bn_sampler sampler = {BN_SAMPLER_BLUE, 8, {0, 0}, NULL, 0x8000000000000u, 0xfffffu, 64, 64, 16};
    /* The finaliser of SplitMix64 (Steele, Lea and Flood, 2014) with Stafford's variant 13. */
    uint64_t v = seed + 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    v ^= v >> 31;
    sampler.seed[0] = v & 0xffffffffu;
    v >>= 32;
    sampler.seed[1] = v & 0xffffffffu;
    return sampler;
}

/* Initialises a sampler of any type. ZORDER is tuned for 256 samples, and MASK uses the built-in 64 x 64
 * mask. Errors: INVALID_ARGUMENT (sampler is NULL or the type is unknown). */
BN_API bn_result bn_sampler_init(bn_sampler *sampler, bn_sampler_type type, uint64_t seed);

/* Initialises a ZORDER sampler tuned for samples_per_pixel samples. That count is rounded up to a power of
 * two, at most 2^16; 0 means 256. Samples beyond that count are valid but less evenly spread. Errors:
 * INVALID_ARGUMENT (sampler is NULL). */
BN_API bn_result bn_sampler_init_zorder(bn_sampler *sampler, uint32_t samples_per_pixel,
                                        uint64_t seed);

/* Initialises a MASK sampler from a single-channel 2-D mask. The mask's ranks must not change while the
 * sampler or a copy of it is in use. Errors: INVALID_ARGUMENT (a NULL pointer, a zero extent, depth or
 * channels other than 1, rank_bits other than 16 or 32), BAD_DATA (the ranks are not a permutation),
 * OUT_OF_MEMORY (the check needs one bit per texel). */
BN_API bn_result bn_sampler_init_mask(bn_sampler *sampler, const bn_mask *mask, uint64_t seed);

/* ---- Draws from domains */

/* Draws sample `index` of pixel (x, y) in a domain. The result depends only on the arguments, so draw order,
 * threading, tiling, cropping and restarts cannot change it. Coordinates may be negative, and each index up
 * to 2^32 - 1 gives a new sample. The sampler must be initialised. Draws cannot fail, do not allocate and
 * take no locks.
 *
 * bn_sample_4d_u32() returns 32 random bits per dimension. Floats are (bits >> 8) * 2^-24, so they are always
 * below 1. The 1-D draw returns dimension 0. The 2-D draw returns dimensions (0, 1) for pair 0 and (2, 3) for
 * pair 1 (only the lowest bit of `pair` counts), and takes no longer than the 4-D draw. bn_draw.h provides
 * inline versions. */
BN_API float bn_sample_1d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                          uint32_t domain);
BN_API void bn_sample_2d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                         uint32_t domain, uint32_t pair, float out[2]);
BN_API void bn_sample_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                         uint32_t domain, float out[4]);
BN_API void bn_sample_4d_u32(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                             uint32_t domain, uint32_t out[4]);

/* Draws a block of samples into out[height][width][index_count][4], starting at pixel (x0, y0) and
 * first_index. The samples are bit-identical to those of bn_sample_4d(). Samples within a pixel share work:
 * if index_count is large, BLUE is faster than single draws, and SOBOL and WHITE are nearly as fast as in a
 * wavefront. Errors: INVALID_ARGUMENT (sampler or out is NULL, an extent is zero, or the block runs past the
 * last coordinate or index), SIZE_MISMATCH. */
BN_API bn_result bn_sample_block(const bn_sampler *sampler, int32_t x0, int32_t y0, uint32_t width,
                                 uint32_t height, uint32_t first_index, uint32_t index_count,
                                 uint32_t domain, float *out, size_t out_count);

/* The lanes of a wavefront, in any order. */
typedef struct bn_wavefront {
    size_t struct_size; /* sizeof(bn_wavefront) */
    size_t count;       /* number of lanes, and length of each array below */
    const int32_t *x, *y;
    /* One per lane, or NULL (default) if all lanes share shared_index and shared_domain. */
    const uint32_t *index, *domain;
    uint32_t shared_index, shared_domain; /* default to 0 and BN_DOMAIN_ROOT */
    /* NULL (default), or one ray number per lane, below 2^28. If set, lane i draws from ray depth[i] of a
     * path whose domain is the lane's domain; BN_DOMAIN_ROOT stands for the path of stream 0. */
    const uint32_t *depth;
    /* Dimension d of lane i goes to out[d][i * stride]. NULL (default) skips the dimension. */
    float *out[4];
    size_t stride; /* default 1; to write u[count][4], set out[d] to u + d and stride to 4 */
} bn_wavefront;

BN_INLINE bn_wavefront bn_wavefront_default(void) {
    bn_wavefront w = {sizeof w, 0, NULL, NULL, NULL, NULL, 0, BN_DOMAIN_ROOT, NULL, {NULL}, 1};
    return w;
}

/* Draws a sample for every lane of a wavefront. The samples are bit-identical to those of bn_sample_4d(). If
 * only one pair is requested, only that pair is drawn. Arrays must be aligned for their element type and must
 * not overlap the outputs. Allocates nothing and takes no locks. With AVX2 (unless the library was built with
 * MSVC or with GCC for Windows), a wavefront takes less than half as long as single draws for BLUE, and a
 * tenth as long for SOBOL and WHITE; for the other types, it is no faster. Errors: INVALID_ARGUMENT (sampler,
 * wavefront, x, y or all of out is NULL, stride is 0, or struct_size is invalid), UNSUPPORTED. */
BN_API bn_result bn_sample_wavefront(const bn_sampler *sampler, const bn_wavefront *wavefront);

/* ---- Drawing on a GPU (docs/shaders.md) */

/* Returns BLUE's table (46.5 KiB), which is the same for every seed; bn_draw.glsl describes it. Sets *count
 * to its length in 32-bit words and *version to the library's BN_DRAW_TABLE_VERSION. Either pointer may be
 * NULL. */
BN_API const uint32_t *bn_tables(size_t *count, uint32_t *version);

/* Copies the sampler's two-word seed for use in shaders. */
BN_INLINE void bn_sampler_seed(const bn_sampler *sampler, uint32_t seed[2]) {
    for (int i = 0; i < 2; ++i) seed[i] = sampler->seed[i];
}

/* ---- Making masks */

/* You can make masks with three algorithms. Void-and-cluster makes good masks in milliseconds on one core.
 * Relaxation is nearly as good, runs faster and uses all cores. Annealing is slow, but 10,000 sweeps reach an
 * E_1 (bn_mask_error) about 4% below void-and-cluster's. All three call `progress` in C's default
 * floating-point environment. Errors: INVALID_ARGUMENT (a NULL pointer, a zero extent, an option out of
 * range, rank_bits too small or other than 16 or 32, a depth or channel count the algorithm does not
 * support), OUT_OF_MEMORY, CANCELLED, UNSUPPORTED. */

typedef struct bn_void_and_cluster_options {
    size_t struct_size; /* sizeof(bn_void_and_cluster_options) */
    /* Standard deviation of the Gaussian in texels, from 0.25 to 16. Default 1.5. Masks made with sigma =
     * 1.9 have lower error if the viewing blur is wider than 1.5 texels. */
    double sigma;
    double initial_fraction; /* fraction of texels set initially, in (0, 0.5]; default 0.1 */
    uint64_t seed;           /* default 0 */
} bn_void_and_cluster_options;

BN_INLINE bn_void_and_cluster_options bn_void_and_cluster_options_default(void) {
    bn_void_and_cluster_options options = {sizeof(bn_void_and_cluster_options), 1.5, 0.1, 0};
    return options;
}

/* Makes a single-channel 2-D or 3-D mask (Ulichney, "The void-and-cluster method for dither array
 * generation", 1993). Runs on the calling thread. A 2-D mask at sigma 1.5 needs 0.16 to 0.4 microseconds and
 * 14 bytes per texel. */
BN_API bn_result bn_void_and_cluster(const bn_void_and_cluster_options *options,
                                     const bn_mask *mask, bn_progress progress, void *user);

typedef struct bn_relax_options {
    size_t struct_size; /* sizeof(bn_relax_options) */
    uint32_t threads;   /* 0 (default): bn_thread_count() */
    uint64_t seed;      /* default 0 */
} bn_relax_options;

BN_INLINE bn_relax_options bn_relax_options_default(void) {
    bn_relax_options options = {sizeof(bn_relax_options), 0, 0};
    return options;
}

/* Makes a single-channel 2-D mask with parallel relaxation. This is the fastest way to make a large mask, and
 * the result is nearly as good as void-and-cluster's. Relaxation starts from white noise and applies 20
 * learned steps. Each step updates all texels at once: it adds to every texel a weighted sum of clipped
 * differences from its neighbours. The final values are then ranked. */
BN_API bn_result bn_relax(const bn_relax_options *options, const bn_mask *mask,
                          bn_progress progress, void *user);

typedef struct bn_anneal_options {
    size_t struct_size; /* sizeof(bn_anneal_options) */
    /* Standard deviation, in texels, of the viewing blur after which the error is minimised: 0.25 to 4.
     * Default 1. Two texels interact with weight exp(-distance^2 / (4 sigma^2)). */
    double sigma;
    /* One channel only: the standard deviation of a second, wider blur, from sigma to 4 (default 1.5; raise
     * it along with sigma), and the weight of its squared error relative to that of the first blur (default
     * 1; 0 turns it off). */
    double far_sigma, far_weight;
    /* Multiple channels only: how close values must be to repel each other, from 0.01 to 100. Default 1. */
    double value_sigma;
    /* Temperatures as fractions of the largest possible gain from one texel's pairs, where 0 < end <= start
     * <= 1. Cooling is geometric. The defaults are 4e-4 and 2e-6, respectively. */
    double start_temperature, end_temperature;
    uint32_t sweeps; /* trial swaps per texel; default 1000 */
    /* One channel only. 1 (default): order the first and last ranks with void-and-cluster, because their
     * texels are too far apart for the blurs to have any effect. 0: keep them as annealed. */
    int32_t order_ends;
    /* 1: start from the mask's ranks. 0 (default): start from void-and-cluster. */
    int32_t start_from_ranks;
    uint64_t seed; /* default 0 */
} bn_anneal_options;

BN_INLINE bn_anneal_options bn_anneal_options_default(void) {
    bn_anneal_options o = {sizeof o, 1, 1.5, 1, 1, 4e-4, 2e-6, 1000, 1, 0, 0};
    return o;
}

/* Makes a 2-D mask with 1 to 4 channels by simulated annealing with swaps (Georgiev and Fajardo, "Blue-noise
 * dithered sampling", 2016).
 *
 * With one channel, it minimises E_sigma^2 + far_weight * E_far_sigma^2, where E is bn_mask_error(). A trial
 * swap takes about 65 ns. With multiple channels, it minimises the sum, over all pairs of texels, of
 * exp(-distance^2 / (4 sigma^2)) * exp(-|difference of values|^(channels / 2) / value_sigma^2), where values
 * are in [0, 1). A trial swap then takes about 1 microsecond. Also fails with BAD_DATA if start_from_ranks is
 * set and the ranks are not permutations. */
BN_API bn_result bn_anneal(const bn_anneal_options *options, const bn_mask *mask,
                           bn_progress progress, void *user);

/* Ranks values: ranks[i] is the number of values less than values[i], plus the number of equal values before
 * it. Takes linear time and 16 bytes of scratch memory per value. Errors: INVALID_ARGUMENT (a NULL pointer, a
 * zero count), BAD_DATA (a NaN), OUT_OF_MEMORY (including for 2^32 values or more). */
BN_API bn_result bn_ranks_from_values(const float *values, size_t count, uint32_t *ranks);

/* Returns a rank's value: (rank + 0.5) / count, computed in double, rounded down to float and limited to 1 -
 * 2^-24. A rank of count or more is treated as count - 1. Returns 0 if count is 0. */
BN_API float bn_rank_to_float(uint32_t rank, size_t count);

/* Returns the built-in mask of size x size texels, whose 16-bit ranks are in static storage (licence:
 * CC0-1.0). Each mask was annealed for up to several minutes and, after a 1-texel blur, has 5% lower error
 * than a void-and-cluster mask. The sizes are 16, 32, 64, 128 and, unless built with BN_SMALL_DATA, 256; for
 * any other size, ranks is NULL. A statically linked program contains these masks (175 KB) only if it calls
 * this function; samplers and bn_dither() use only the 64 x 64 mask. */
BN_API bn_mask bn_builtin_mask(uint32_t size);

/* ---- Using masks */

/* Computes a 2-D mask's dithering error E_sigma; lower is better. E_sigma is the root mean square, over
 * texels and the 64 thresholds t = (i + 0.5) / 64, of G_sigma * [m < t] - t. Here m is the mask's value (rank
 * + 0.5) / count, and G_sigma is a toroidal Gaussian of sigma texels whose transfer function is exp(-2 pi^2
 * sigma^2 f^2). White noise has an error of 0.1152 at sigma 1. Errors: see bn_sampler_init_mask(); also
 * INVALID_ARGUMENT (sigma is negative or not finite), CANCELLED. */
BN_API bn_result bn_mask_error(const bn_mask *mask, double sigma, double *error,
                               bn_progress progress, void *user);

/* Computes a 2-D mask's power spectrum: power[v * width + u] is |DFT|^2 at frequency (u / width, v / height)
 * cycles per texel (subtract 1 from frequencies above 1/2), divided by the sum of the ranks' squared
 * deviations from their mean. White noise has an expected power of 1 everywhere. power[0] is 0. Errors: see
 * bn_sampler_init_mask(); also SIZE_MISMATCH (count is not width * height), CANCELLED. */
BN_API bn_result bn_power_spectrum(const bn_mask *mask, float *power, size_t count,
                                   bn_progress progress, void *user);

typedef struct bn_dither_options {
    size_t struct_size; /* sizeof(bn_dither_options) */
    uint32_t levels;    /* number of evenly spaced output levels from 0 to 1: 2 (default) to 256 */
    /* 0 (default): preserve the local mean of the values. 1: input and output are sRGB-encoded; preserve the
     * local mean of linear light. */
    int32_t srgb;
    /* 1 (default): shift the mask from channel to channel so that the channels' errors are uncorrelated. */
    int32_t channel_offset;
    const bn_mask *mask; /* 2-D, single-channel; NULL (default): the built-in 64 x 64 mask */
} bn_dither_options;

BN_INLINE bn_dither_options bn_dither_options_default(void) {
    bn_dither_options options = {sizeof(bn_dither_options), 2, 0, 1, NULL};
    return options;
}

/* Dithers image[height][width][channels], whose values are in [0, 1], to a few levels. A value v becomes
 * floor(v * (levels - 1) + t) / (levels - 1), where t is the mask's value (rank + 0.5) / texels at that
 * pixel. Values outside [0, 1] are clamped; 0 and 1 are unchanged. If srgb is set, the fractional part of v *
 * (levels - 1) is adjusted to preserve the linear light of v. `out` may be the same array as `image`. Errors:
 * for the mask, see bn_sampler_init_mask(); also INVALID_ARGUMENT (a NULL pointer, a zero extent, an option
 * out of range), SIZE_MISMATCH, BAD_DATA (a NaN in the image), OUT_OF_MEMORY, UNSUPPORTED. */
BN_API bn_result bn_dither(const bn_dither_options *options, const float *image, uint32_t width,
                           uint32_t height, uint32_t channels, float *out, size_t count);

/* ---- Visible noise of a render */

typedef struct bn_visible_noise_options {
    size_t struct_size; /* sizeof(bn_visible_noise_options) */
    /* Standard deviation of the eye's blur in pixels, 0 to 16. Default 2.1: a display with 96 pixels per inch
     * seen from 75 cm. It is proportional to pixels per inch times distance; docs/stop.md has a table. */
    double sigma;
    /* Factor from image values to linear light with white at 1, 1e-30 to 1e30. Default 1. */
    double exposure;
    double first_share; /* fraction of all samples in `first`, 0.001 to 0.999. Default 0.5 */
    /* Side in pixels of the square over which the noise is pooled, centred on each pixel: odd, 1 to 1023.
     * Default 33. Smaller squares are more local and less certain. */
    uint32_t window;
    uint32_t threads; /* 0 (default): one per CPU */
} bn_visible_noise_options;

BN_INLINE bn_visible_noise_options bn_visible_noise_options_default(void) {
    bn_visible_noise_options o = {sizeof(bn_visible_noise_options), 2.1, 1, 0.5, 33, 0};
    return o;
}

/* Estimates how much noise a viewer sees in a render, without a reference. Input: the means of two disjoint
 * sets of samples, such as the first and the second half, as linear images[height][width][channels], and
 * `count`, the number of values in each. Output: map[height][width], the root mean square error of the mean
 * of all samples, in steps of an 8-bit sRGB display, as seen through the blur. Below 1, noise is hard to see;
 * at 3, it is obvious. Values are clipped to [0, 1] after exposure, as on a display; channels are measured
 * separately, and their squares averaged. Samplers with a net in each pixel, such as BLUE and SOBOL, have about
 * 10% lower noise than estimated (up to 40% in single scenes), because the errors of their halves partly
 * cancel.
 *
 * Images are mirrored at their edges. Images of more than 64 rows are measured in every second row if sigma is
 * at least 1.5 and window at least 9. Measuring a crop therefore changes the map only near the crop's edges if
 * the crop starts at an even row and has more than 64 rows, and otherwise by about 1%. Features that no sample
 * has found are missing from the estimate (docs/stop.md). Takes 13 ns per value on one core. Each thread needs
 * about 0.5 MB for three channels and the default options. A call that fails leaves the map untouched, except
 * that CANCELLED leaves it partly written. The map must not overlap the images.
 * Errors: INVALID_ARGUMENT (a NULL pointer, a zero extent, an option out of range), SIZE_MISMATCH (count or
 * map_count), BAD_DATA (a NaN), OUT_OF_MEMORY, CANCELLED, UNSUPPORTED. */
BN_API bn_result bn_visible_noise(const bn_visible_noise_options *options, const float *first,
                                  const float *second, uint32_t width, uint32_t height,
                                  uint32_t channels, size_t count, float *map, size_t map_count,
                                  bn_progress progress, void *user);

#ifdef __cplusplus
}
#endif

#undef BN_CONSTEXPR
#undef BN_INLINE
#undef BN_UNREAD

#endif
