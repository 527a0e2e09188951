/* SPDX-License-Identifier: Apache-2.0
 * Single-channel annealing, whose energy is the dithering error itself.
 *
 * Summed over all thresholds, the squared error E_sigma^2 is a constant minus the sum over pairs of
 * W(p - q) |r_p - r_q|, where W is a Gaussian of width sigma sqrt(2), the autocorrelation of the
 * blur. This follows from |a - b| = a + b - 2 min(a, b). Swapping the ranks a < b of two texels
 * changes the sum by the difference of two sums of W clamp(r, a, b) over their windows, so a trial
 * costs two windows of 16-bit multiplications. Half of the trials swap a texel with one of similar
 * rank, the other half with a nearby one. */
#include "base/memory.h"
#include "masks/anneal_job.h"
#include "simd/simd.h"

/* The sum of the weights before rounding. A window's weights add up to at most 760 more, and 32,760 times the
 * largest difference of two reduced ranks is below 2^31, so the difference of two windows fits in 32 bits. */
enum { BN_ANNEAL_WEIGHT_SUM = 32000 };

typedef struct board {
    bn_anneal_job *job;
    const bn_simd *simd;
    uint32_t rows, row_lanes; /* of a window; lanes beyond 2 reach + 1 weigh nothing */
    size_t stride, image_rows;
    /* [image_rows][stride]: reduced ranks with a toroidal margin. Texel (x, y) is at (x, y) + reach, so the
     * window around it starts at (x, y). */
    int16_t *image;
    int16_t *weights;    /* [rows][row_lanes], 0 at the centre */
    uint32_t *positions; /* the texel of each rank */
} board;

/* A rank reduced to 16 bits, starting at -32768. In large masks several ranks share a value, and
 * swapping those gains nothing. */
static int16_t reduced(const board *b, uint32_t rank) {
    const uint32_t texels = b->job->texels;
    if (texels > 65536) rank = (uint32_t)((uint64_t)rank * 65536 / texels);
    return (int16_t)((int32_t)rank - 32768);
}

/* Writes a texel and its copies in the margin. */
static void place(board *b, uint32_t p, uint32_t rank) {
    const bn_anneal_job *job = b->job;
    BN_ASSERT(p < job->texels && rank < job->texels);
    const uint32_t x = p % job->width, y = p / job->width;
    const int16_t value = reduced(b, rank);
    job->ranks[p] = rank;
    b->positions[rank] = p;
    for (size_t row = (y + job->reach[1]) % job->height; row < b->image_rows; row += job->height) {
        for (size_t at = (x + job->reach[0]) % job->width; at < b->stride; at += job->width) {
            b->image[row * b->stride + at] = value;
        }
    }
}

/* Swaps the ranks of p and q unless that loses more than `allowance`. */
static void try_swap(board *b, uint32_t p, uint32_t q, double allowance) {
    const bn_anneal_job *job = b->job;
    if (job->ranks[p] > job->ranks[q]) {
        uint32_t t = p;
        p = q;
        q = t;
    }
    const uint32_t low = job->ranks[p], high = job->ranks[q];
    BN_ASSERT(low < high); /* the ranks are a permutation, and p differs from q */
    BN_ASSERT(b->positions[low] == p && b->positions[high] == q);
    const uint32_t px = p % job->width, py = p / job->width;
    const uint32_t qx = q % job->width, qy = q / job->width;
    const int16_t a = reduced(b, low), c = reduced(b, high);
    /* The energy that the swap saves: see the top of this file. */
    int64_t gain =
        b->simd->window_difference(b->image + py * b->stride + px, b->image + qy * b->stride + qx,
                                   b->stride, b->weights, b->rows, b->row_lanes, a, c);
    /* A swap does not change the pair's own term: undo the windows' contributions to it. */
    const int32_t dx = bn_anneal_offset(px, qx, job->width) + (int32_t)job->reach[0];
    const int32_t dy = bn_anneal_offset(py, qy, job->height) + (int32_t)job->reach[1];
    if (dx >= 0 && dx <= 2 * (int32_t)job->reach[0] && dy >= 0 &&
        dy <= 2 * (int32_t)job->reach[1]) {
        gain += (int64_t)b->weights[(size_t)dy * b->row_lanes + (size_t)dx] * (c - a);
    }
    if ((double)gain >= -allowance) {
        place(b, p, high);
        place(b, q, low);
    }
}

/* Runs one sweep. Returns 0 if cancelled. */
static int run_sweep(board *b, uint32_t sweep, double temperature) {
    bn_anneal_job *job = b->job;
    const uint32_t texels = job->texels, farthest = texels / 32 + 1; /* in ranks */
    for (uint32_t trial = 0; trial < texels; ++trial) {
        if (bn_anneal_cancelled(job, sweep, trial)) return 0;
        const uint64_t bits = bn_random_next(&job->random);
        /* Bits 32 to 63 choose p; 0 to 11 the allowance, 12 and 13 the type of move, 14 to 31 its size. */
        const uint32_t p = (uint32_t)((bits >> 32) * texels >> 32);
        const double allowance = temperature * job->logs[bits & (BN_ANNEAL_LOG_SIZE - 1)];
        const uint32_t choice = (uint32_t)(bits >> 14 & 0x3ffff);
        uint32_t q;
        if (bits >> 12 & 1) {
            const uint32_t step = 1 + (uint32_t)((uint64_t)choice * farthest >> 18);
            const uint32_t rank = job->ranks[p];
            if (bits >> 13 & 1 ? rank < step : step >= texels - rank) continue;
            q = b->positions[bits >> 13 & 1 ? rank - step : rank + step];
        } else {
            q = bn_anneal_neighbour(job, p, choice % 49);
            if (q == p) continue;
        }
        try_swap(b, p, q, allowance);
    }
    return 1;
}

/* Adds the Gaussians of both blurs, each with a volume of one, weighted by far_weight. Both are scaled by a
 * power of two, which changes no bit of the result, so that no weight overflows. */
static void fill_weights(board *b) {
    const bn_anneal_options *o = b->job->options;
    const int32_t rx = (int32_t)b->job->reach[0], ry = (int32_t)b->job->reach[1];
    const int has_far = o->far_weight > 0; /* otherwise far_sigma can be any number */
    int exponent = 0;
    if (o->far_weight > 1) frexp(o->far_weight, &exponent);
    const double near_share = ldexp(1 / (o->sigma * o->sigma), -exponent);
    const double far_share =
        has_far ? ldexp(o->far_weight, -exponent) / (o->far_sigma * o->far_sigma) : 0;
    double scale = 0;
    for (int pass = 0; pass < 2; ++pass) {
        double sum = 0;
        for (int32_t y = -ry; y <= ry; ++y) {
            for (int32_t x = -rx; x <= rx; ++x) {
                if (x == 0 && y == 0) continue;
                double square = (double)x * x + (double)y * y;
                double w = near_share * bn_portable_exp(-square / (4 * o->sigma * o->sigma));
                if (has_far)
                    w += far_share * bn_portable_exp(-square / (4 * o->far_sigma * o->far_sigma));
                sum += w;
                b->weights[(size_t)(y + ry) * b->row_lanes + (size_t)(x + rx)] =
                    (int16_t)(w * scale + 0.5);
            }
        }
        scale = BN_ANNEAL_WEIGHT_SUM / sum; /* the first pass only measures the sum */
    }
    int64_t whole = 0;
    for (size_t i = 0; i < (size_t)b->rows * b->row_lanes; ++i) whole += b->weights[i];
    BN_ASSERT(whole * UINT16_MAX <= INT32_MAX);
}

bn_result bn_anneal_scalar(bn_anneal_job *job) {
    board b = {.job = job, .simd = bn_simd_get(), .rows = 2 * job->reach[1] + 1};
    bn_result result = BN_ERROR_OUT_OF_MEMORY;
    b.row_lanes = (2 * job->reach[0] + BN_WINDOW_LANES) / BN_WINDOW_LANES * BN_WINDOW_LANES;
    b.stride = (size_t)job->width + b.row_lanes;
    b.image_rows = (size_t)job->height + 2 * job->reach[1];
    b.image = bn_allocate(b.image_rows, b.stride * sizeof *b.image);
    b.weights = bn_allocate_zero(b.rows, b.row_lanes * sizeof *b.weights);
    b.positions = bn_allocate(job->texels, sizeof *b.positions);
    if (b.image == NULL || b.weights == NULL || b.positions == NULL) goto done;
    fill_weights(&b);
    for (uint32_t p = 0; p < job->texels; ++p) place(&b, p, job->ranks[p]);
    /* One window's largest gain: its weights times the largest difference of two reduced ranks. */
    const double most = BN_ANNEAL_WEIGHT_SUM * (job->texels < 65536 ? job->texels : 65536.0);
    result = BN_SUCCESS;
    for (uint32_t s = 0; s < job->options->sweeps && result == BN_SUCCESS; ++s) {
        if (!run_sweep(&b, s, most * bn_anneal_temperature(job, s))) result = BN_ERROR_CANCELLED;
    }
done:
    bn_free(b.image);
    bn_free(b.weights);
    bn_free(b.positions);
    return result;
}
