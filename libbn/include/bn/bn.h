/* SPDX-License-Identifier: Apache-2.0
 * libbn: blue noise for path tracers. This header is the whole public API and its manual.
 *
 * CONVENTIONS
 *
 * Results. Every function that can fail returns a bn_result; it prints nothing and never aborts.
 * Unless a function says otherwise, outputs are untouched when it fails.
 *
 * Options. A function that takes an options structure accepts NULL for the defaults. Start from the
 * matching bn_*_options_default(), which fills struct_size, and change what you need. A structure
 * from an older, shorter version of this header gets defaults for what it lacks; one from a newer
 * version is accepted when the part this library does not know is all zero bytes, otherwise the
 * result is BN_ERROR_UNSUPPORTED.
 *
 * Arrays. Masks and images are row-major, x fastest: element (x, y, z) of a mask is at
 * ranks[(z * height + y) * width + x]. Every array comes with its element count; a count that is not
 * the product of the extents is BN_ERROR_SIZE_MISMATCH.
 *
 * Ranks. A mask holds every rank 0 .. count - 1 exactly once and tiles the plane (it is toroidal).
 *
 * Threads. Every function may be called from any number of threads. Objects are immutable once
 * created.
 *
 * Reproducibility. The samplers and the classical mask generators give the same bits for the same
 * seed on every machine, with every compiler and number of threads.
 */
#ifndef BN_BN_H
#define BN_BN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The one place that holds the version; the build files read it from here. */
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

/* ---- Results */

typedef int32_t bn_result;

enum {
    BN_SUCCESS = 0,
    BN_ERROR_INVALID_ARGUMENT = 1, /* an argument is NULL, zero, not finite or out of its range */
    BN_ERROR_SIZE_MISMATCH = 2,    /* an array's count is not the product of its extents */
    BN_ERROR_OUT_OF_MEMORY = 3,    /* an allocation failed, or the work would not fit in memory */
    BN_ERROR_BAD_DATA = 4,    /* ranks that are no permutation, NaN among values, a foreign file */
    BN_ERROR_UNSUPPORTED = 5, /* an option of a newer header, or a combination not offered */
    BN_ERROR_RUNTIME = 6,     /* ONNX Runtime is missing or failed */
    BN_ERROR_IO = 7,          /* a file cannot be opened, read or written */
    BN_ERROR_CANCELLED = 8    /* a progress callback asked to stop */
};

/* A short English description of a result; never NULL, also for values that are no result. */
BN_API const char *bn_result_string(bn_result result);

/* The version of the library that is linked, as "major.minor.patch". */
BN_API const char *bn_version_string(void);

/* Called now and then by long work with fraction in [0, 1], always from the calling thread.
 * Return non-zero to cancel: the work returns BN_ERROR_CANCELLED. */
typedef int32_t (*bn_progress)(void *user, double fraction);

/* ---- Domains */

/* A domain names one decision of a path: "the lens", "the light sample of bounce 3". Samples of one
 * domain are well distributed over a pixel's indices and blue over the screen; samples of different
 * domains are independent. Derive domains along the call tree, so that adding a decision somewhere
 * does not change the samples of another:
 *
 *     uint32_t frame   = bn_domain_child(BN_DOMAIN_ROOT, frame_number);
 *     uint32_t pixel   = bn_domain_child(frame, 0);
 *     uint32_t light   = bn_domain_child(frame, 1 + 2 * bounce);
 *     uint32_t scatter = bn_domain_child(frame, 2 + 2 * bounce);
 *
 * A domain has four dimensions: (0, 1) and (2, 3) are the pairs to spend on two-dimensional
 * decisions. With BLUE both pairs of a domain are stratified together as well, in all four
 * dimensions and over neighbouring pixels, and so, nearly, are any two of the four children that a
 * domain has by the keys 4 k to 4 k + 3: a family. So give decisions whose effects multiply, like the
 * position in the pixel and the point on a light, the two pairs of one domain, or keys of one family.
 *
 * Draw the position in the pixel from dimensions (0, 1), as (x, y), of a domain whose key is a
 * multiple of four: these are also even along rows and columns of the picture, where edges that
 * are parallel to its sides add up errors over a line one pixel wide. */
#define BN_DOMAIN_ROOT 0u

/* The child of a domain by a key: a hash of the domain and of key / 4, with key % 4 as the place in
 * the family. Any values are good. Cost: about a nanosecond. */
BN_API uint32_t bn_domain_child(uint32_t domain, uint32_t key);

/* ---- Samplers */

typedef struct bn_sampler bn_sampler;

enum {
    /* The sampler to use: progressive, blue on screen in both pairs of every domain. In each pixel
     * every power-of-two prefix is a (0,m,2)-net in dimensions (0,1) and in (2,3), and every prefix
     * of 4^m samples a (0,m,4)-net to base 4 in all four; taken over the pixels of an aligned block
     * of 16^s, the same prefix is a (0, m + 2 s, 4)-net. Needs no sample count. docs/blue.md has the
     * construction. */
    BN_SAMPLER_BLUE = 0,
    /* Owen-scrambled Sobol' (0,2)-sequences, padded, independent in each pixel: what to compare
       with. */
    BN_SAMPLER_SOBOL = 1,
    /* Independent uniform numbers. */
    BN_SAMPLER_WHITE = 2,
    /* One Sobol' sequence along a scrambled Morton curve over the pixels (Ahmed and Wonka,
     * "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of
     * Pixels", 2020). Good when exactly samples_per_pixel samples are taken, no better than SOBOL
     * when stopped early. */
    BN_SAMPLER_ZORDER = 3,
    /* A mask makes the first sample of every pixel, a digitally shifted, scrambled Sobol'
     * (0,2)-sequence the others: the use of blue-noise textures, without their loss at higher
     * counts. Blue at 1 sample, slightly at 2 and 3, about SOBOL from 4 on. */
    BN_SAMPLER_MASK = 4
};

typedef struct bn_sampler_options {
    size_t struct_size; /* sizeof(bn_sampler_options) */
    int32_t kind;       /* BN_SAMPLER_..., default BN_SAMPLER_BLUE */
    /* Only ZORDER reads it: the count it is good at, rounded up to a power of two (at most 2^16); 0
     * (default) is taken as 256. The other kinds are good at every count. Later indices remain valid
     * in all of them. */
    uint32_t samples_per_pixel;
    /* Different seeds give independent pictures; default 0. */
    uint64_t seed;
    /* Kind MASK: a permutation, copied. NULL (default): the built-in 64x64. */
    const uint32_t *mask_ranks;
    /* Extents of mask_ranks, in texels; 0 when mask_ranks is NULL. */
    uint32_t mask_width, mask_height;
} bn_sampler_options;

static inline bn_sampler_options bn_sampler_options_default(void) {
    bn_sampler_options options = {sizeof(bn_sampler_options), BN_SAMPLER_BLUE, 0, 0, NULL, 0, 0};
    return options;
}

/* Creates a sampler. Errors: INVALID_ARGUMENT (sampler NULL, unknown kind, a mask with a zero
 * extent, extents without a mask, a mask given to another kind than MASK), BAD_DATA (mask_ranks is
 * no permutation), UNSUPPORTED, OUT_OF_MEMORY (also for a mask of more than 2^31 - 1 texels). On failure *sampler is NULL. */
BN_API bn_result bn_sampler_create(const bn_sampler_options *options, bn_sampler **sampler);
BN_API void bn_sampler_destroy(bn_sampler *sampler);

/* Draws. The sample `index` of a pixel (x, y) in a domain: a pure function of its arguments, so
 * order, threads, tiles, crops and restarts cannot change it. Coordinates may be negative; every
 * index up to 2^32 - 1 is a new sample. Draws need a valid sampler, cannot fail, allocate nothing
 * and lock nothing.
 *
 * bn_sample_4d_u32 gives 32 random bits per dimension. The floats are out[i] = (u32[i] >> 8) *
 * 2^-24, always in [0, 1). The 2-D draw is the first two, the 1-D draw the first of the 4-D draw.
 */
BN_API float bn_sample_1d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                          uint32_t domain);
BN_API void bn_sample_2d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                         uint32_t domain, float out[2]);
BN_API void bn_sample_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                         uint32_t domain, float out[4]);
BN_API void bn_sample_4d_u32(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                             uint32_t domain, uint32_t out[4]);

/* Many draws at once: out[height][width][index_count][4], bit-equal to bn_sample_4d. The block
 * covers pixels x0 .. x0 + width - 1, y0 .. y0 + height - 1 and indices first_index .. first_index
 * + index_count - 1. Errors: INVALID_ARGUMENT (sampler or out NULL, an extent zero, a range that
 * runs past the last coordinate or index), SIZE_MISMATCH. */
BN_API bn_result bn_sample_block(const bn_sampler *sampler, int32_t x0, int32_t y0, uint32_t width,
                                 uint32_t height, uint32_t first_index, uint32_t index_count,
                                 uint32_t domain, float *out, size_t out_count);

/* The tables of a sampler as one flat buffer, for the draws of a shader: bn_draw.glsl says what is
 * in it. With words NULL only *needed is set, to the number of words (42 KiB in all). needed may be
 * NULL otherwise. Errors: INVALID_ARGUMENT (sampler NULL, both words and needed NULL),
 * SIZE_MISMATCH (count is not the number of words). */
BN_API bn_result bn_sampler_table_words(const bn_sampler *sampler, uint32_t *words, size_t count,
                                        size_t *needed);

/* ---- Making masks */

/* Void-and-cluster makes good masks in milliseconds, on one core. Relaxation is nearly as good and
 * uses all cores: for large masks. Annealing is slow and the best. All three give the same bits for
 * the same options on every machine and leave ranks as they were when they fail. */

typedef struct bn_void_and_cluster_options {
    size_t struct_size; /* sizeof(bn_void_and_cluster_options) */
    double sigma;       /* standard deviation of the Gaussian, in texels; default 1.5. About 1.5 is
                           best seen from near, 1.9 from further away. In [0.25, 16] */
    double initial_fraction; /* share of texels in the initial pattern; default 0.1, in (0, 0.5] */
    uint64_t seed;           /* default 0 */
    bn_progress progress;    /* default NULL */
    void *progress_user;
} bn_void_and_cluster_options;

static inline bn_void_and_cluster_options bn_void_and_cluster_options_default(void) {
    bn_void_and_cluster_options options = {
        sizeof(bn_void_and_cluster_options), 1.5, 0.1, 0, NULL, NULL};
    return options;
}

/* Void-and-cluster (Ulichney, "The void-and-cluster method for dither array generation", 1993) on a
 * torus of width x height x depth texels; 1 for the extents a mask does not have. Any extents will
 * do. Writes every rank once; level with the method as published at every grey level, better at
 * both ends. Runs on the calling thread; about 0.2 microseconds per texel (2-D, sigma 1.5) and 14
 * bytes, both close to linear. Errors: INVALID_ARGUMENT (ranks NULL, a zero extent, an option out
 * of its range), SIZE_MISMATCH, OUT_OF_MEMORY (also for more than 2^31 - 1 texels), CANCELLED,
 * UNSUPPORTED. */
BN_API bn_result bn_void_and_cluster(const bn_void_and_cluster_options *options, uint32_t width,
                                     uint32_t height, uint32_t depth, uint32_t *ranks,
                                     size_t count);

typedef struct bn_relax_options {
    size_t struct_size; /* sizeof(bn_relax_options) */
    double sigma;       /* the viewing blur whose error falls, in texels; default 0.92, in
                           [0.25, 2.5] */
    double start_step;  /* how far the gradient moves values, in value ranges; default 4. To finish
                           a mask from elsewhere take about 0.1. At most 8 */
    double end_step;    /* default 0.05; geometric in between */
    double start_softness; /* difference of values at which a pair's force is full, in value ranges;
                              default 0.45, at most 0.49. To finish a mask take about 0.02 */
    double end_softness;   /* default 0.008 */
    uint32_t steps;        /* default 64 */
    uint32_t threads;      /* 0 (default): one per processor. The result does not depend on it */
    int32_t start_from_ranks; /* 0 (default): start from white noise of the seed; 1: from ranks */
    uint64_t seed;            /* default 0 */
    bn_progress progress;     /* default NULL; called before each step */
    void *progress_user;
} bn_relax_options;

static inline bn_relax_options bn_relax_options_default(void) {
    bn_relax_options options = {
        sizeof(bn_relax_options), 0.92, 4, 0.05, 0.45, 0.008, 64, 0, 0, 0, NULL, NULL};
    return options;
}

/* Parallel relaxation of a mask: all texels move at once up the gradient of the closed form of
 * E_sigma, ranks are given anew after every step. The fastest way to large masks on several cores,
 * a little behind void-and-cluster in quality. ranks is read only with start_from_ranks. Errors:
 * INVALID_ARGUMENT, SIZE_MISMATCH, BAD_DATA (ranks to start from are no permutation), OUT_OF_MEMORY
 * (also for more than 2^31 - 1 texels), CANCELLED (ranks untouched), UNSUPPORTED. */
BN_API bn_result bn_relax(const bn_relax_options *options, uint32_t width, uint32_t height,
                          uint32_t *ranks, size_t count);

typedef struct bn_anneal_options {
    size_t struct_size; /* sizeof(bn_anneal_options) */
    double sigma;       /* the viewing blur whose error is minimised, in texels; default 1, in
                           [0.25, 4]. Texels interact by exp(-distance^2 / (4 sigma^2)) */
    double far_sigma;   /* one channel: a second, wider blur; default 1.5, in [sigma, 4] */
    double far_weight;  /* one channel: the weight of the second blur's squared error against the
                           first's; default 1, 0 for none */
    double value_sigma; /* several channels: how near values must be to repel each other; default
                           1, in [0.01, 100] */
    double start_temperature; /* as a share of all that one texel's pairs can gain; default 4e-4 */
    double end_temperature;   /* default 2e-6; geometric in between. 0 < end <= start <= 1 */
    uint32_t sweeps;          /* trial swaps per texel; default 1000 */
    int32_t
        order_ends; /* one channel: 1 (default): order the first and the last ranks, whose texels
                       are too far apart for the blurs to see, as void-and-cluster does. 0: no */
    int32_t
        start_from_ranks; /* 0 (default): start from void-and-cluster of the seed; 1: from ranks */
    uint64_t seed;        /* default 0 */
    bn_progress progress; /* default NULL; called before each sweep */
    void *progress_user;
} bn_anneal_options;

static inline bn_anneal_options bn_anneal_options_default(void) {
    bn_anneal_options options = {
        sizeof(bn_anneal_options), 1, 1.5, 1, 1, 4e-4, 2e-6, 1000, 1, 0, 0, NULL, NULL};
    return options;
}

/* Simulated annealing of a mask by swaps (Georgiev and Fajardo, "Blue-noise dithered sampling",
 * 2016): slow, and the best masks there are. ranks[channels][height][width], 1 to 4 channels, each
 * channel a permutation, on output and, with start_from_ranks, on input. One channel: minimises
 * E_sigma^2 + far_weight * E_far_sigma^2 of bn_mask_error, about 50 ns per trial. Several:
 * minimises the sum over pairs of texels of exp(-distance^2 / (4 sigma^2)) * exp(-|difference of
 * values|^(channels / 2) / value_sigma^2), values in [0, 1); about 1 microsecond. Errors:
 * INVALID_ARGUMENT, SIZE_MISMATCH (count is not width * height * channels), BAD_DATA (ranks to
 * start from are no permutation), OUT_OF_MEMORY, CANCELLED, UNSUPPORTED. */
BN_API bn_result bn_anneal(const bn_anneal_options *options, uint32_t width, uint32_t height,
                           uint32_t channels, uint32_t *ranks, size_t count);

/* Ranks of values: ranks[i] is the number of values that are smaller than values[i], or equal and
 * at a smaller position. Linear time. Errors: INVALID_ARGUMENT (a NULL, zero count),
 * BAD_DATA (NaN), OUT_OF_MEMORY (also for more than 2^32 - 1 values). */
BN_API bn_result bn_ranks_from_values(const float *values, size_t count, uint32_t *ranks);

/* The value of a rank: (rank + 0.5) / count in double, rounded down to float, at most 1 - 2^-24. A
 * rank that is not below count counts as count - 1; 0 for a count of 0. */
BN_API float bn_rank_to_float(uint32_t rank, size_t count);

/* ---- Built-in masks */

/* Annealed for minutes: better than masks made on the spot. CC0-1.0. */

/* The built-in mask of size x size texels, its ranks 0 .. size * size - 1, in static storage. There
 * are 16, 32, 64, 128 and, unless the library was built with BN_SMALL_DATA, 256; NULL for other
 * sizes. */
BN_API const uint16_t *bn_builtin_mask(uint32_t size);

/* The same as 32-bit ranks. Errors: INVALID_ARGUMENT (ranks NULL, no such size), SIZE_MISMATCH. */
BN_API bn_result bn_builtin_mask_copy(uint32_t size, uint32_t *ranks, size_t count);

/* ---- Measuring masks */

/* The dithering error E_sigma of a 2-D mask, lower is better: the root mean square, over texels and
 * the 64 thresholds t = (i + 0.5) / 64, of G_sigma * [m < t] - t, where m = (rank + 0.5) / count
 * and G_sigma is a toroidal Gaussian of sigma texels, applied as the transfer function exp(-2 pi^2
 * sigma^2 f^2). White noise has 0.1152 at sigma 1. Errors: INVALID_ARGUMENT (NULL, a zero extent,
 * sigma not finite or negative), SIZE_MISMATCH, BAD_DATA (no permutation), OUT_OF_MEMORY (also for
 * more than 2^31 - 1 texels). */
BN_API bn_result bn_mask_error(const uint32_t *ranks, uint32_t width, uint32_t height, size_t count,
                               double sigma, double *error);

/* The power spectrum of a 2-D mask: power[v * width + u] is the squared magnitude of the discrete
 * Fourier transform at frequency (u / width, v / height) cycles per texel, over the sum of the
 * squared deviations of the ranks from their mean. So white noise has 1 everywhere; frequencies
 * above 1/2 are the negative ones less 1; the constant, power[0], is 0. Errors: INVALID_ARGUMENT
 * (NULL, a zero extent), SIZE_MISMATCH, BAD_DATA (no permutation), OUT_OF_MEMORY (also for more
 * than 2^31 - 1 texels). */
BN_API bn_result bn_power_spectrum(const uint32_t *ranks, uint32_t width, uint32_t height,
                                   size_t count, float *power);

/* ---- Dithering */

typedef struct bn_dither_options {
    size_t struct_size; /* sizeof(bn_dither_options) */
    uint32_t levels;    /* evenly spaced output levels from 0 to 1, 2 (default) to 256 */
    int32_t srgb;       /* 0 (default): keep local means of the values as they are. 1: values are
                           sRGB-encoded, and so is the output; keep local means of their light */
    int32_t channel_offset; /* 1 (default): each channel reads the mask at an offset of its own, so
                               that the channels' errors do not correlate. 0: all read it alike */
    const uint32_t
        *mask_ranks;     /* a mask of any extents, tiled; NULL (default): the built-in 64x64 */
    uint32_t mask_width; /* its extents, in texels; 0 when mask_ranks is NULL */
    uint32_t mask_height;
} bn_dither_options;

static inline bn_dither_options bn_dither_options_default(void) {
    bn_dither_options options = {sizeof(bn_dither_options), 2, 0, 1, NULL, 0, 0};
    return options;
}

/* Dithers an image[height][width][channels] of values in [0, 1] to few levels: a value v becomes
 * floor(v * (levels - 1) + t) / (levels - 1), t the mask's value (rank + 0.5) / texels at the
 * pixel. 0 and 1 stay 0 and 1; values outside count as the nearer of them. With srgb, v * (levels -
 * 1) has its fraction replaced by the one that gives v's light. `out` may be `image`. Errors:
 * INVALID_ARGUMENT (image or out NULL, a zero extent, levels, a mask with a zero extent or extents
 * without a mask), SIZE_MISMATCH, BAD_DATA (NaN in the image, ranks that are no permutation),
 * OUT_OF_MEMORY. */
BN_API bn_result bn_dither(const bn_dither_options *options, const float *image, uint32_t width,
                           uint32_t height, uint32_t channels, float *out, size_t count);

#ifdef __cplusplus
}
#endif

#endif
