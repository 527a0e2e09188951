/* SPDX-License-Identifier: Apache-2.0
 * Annealing of two to four channels. The energy is that of Georgiev and Fajardo ("Blue-noise
 * dithered sampling", 2016): the sum over pairs of texels of exp(-|p - q|^2 / (4 sigma^2)) times
 * exp(-|v_p - v_q|^(channels / 2) / value_sigma^2). A trial swaps the values of one channel, or of
 * all channels, between two texels. Each trial costs two windows of table lookups per texel. */
#include "base/memory.h"
#include "masks/anneal_job.h"

enum {
    BN_VECTOR_BITS = 12,                       /* per value */
    BN_VECTOR_TABLE = 4096,                    /* entries for squared distances from 0 to 4 */
    BN_VECTOR_SHIFT = 2 * BN_VECTOR_BITS - 10, /* from squared distance to table entry */
    BN_VECTOR_ONE =
        1 << 14 /* of weights and table entries: a window's sum of products fits 64 bits */
};

typedef struct field {
    bn_anneal_job *job;
    int16_t *values;     /* [texels][4], of BN_VECTOR_BITS bits; absent channels are 0 */
    uint32_t *positions; /* [channels][texels]: the texel of each rank */
    int32_t *weights;    /* [2 reach[1] + 1][2 reach[0] + 1], of the distance on the torus */
    int32_t table[BN_VECTOR_TABLE + 1]; /* weights of the distance between values; see entry() */
} field;

/* The table entry for the distance of two vectors. */
static uint32_t entry(const int16_t *a, const int16_t *b) {
    int32_t sum = 0;
    for (int c = 0; c < 4; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
    BN_ASSERT(sum >> BN_VECTOR_SHIFT <= BN_VECTOR_TABLE);
    return (uint32_t)sum >> BN_VECTOR_SHIFT;
}

/* The increase in energy of p's pairs when its value changes from `old` to `new`. The pair with
 * `other` is left out, because swapping any channels preserves the distance within the pair. */
static int64_t change_vectors(const field *f, uint32_t p, uint32_t other, const int16_t *old,
                              const int16_t *new) {
    const bn_anneal_job *job = f->job;
    BN_ASSERT(p != other);
    const uint32_t rx = job->reach[0], ry = job->reach[1], width = job->width;
    const uint32_t x0 = (p % width + width - rx) % width;
    uint32_t y = (p / width + job->height - ry) % job->height;
    const int32_t *weight = f->weights;
    int64_t sum = 0;
    for (uint32_t row = 0; row <= 2 * ry; ++row) {
        uint32_t x = x0;
        for (uint32_t column = 0; column <= 2 * rx; ++column, ++weight) {
            const uint32_t n = y * width + x;
            if (++x == width) x = 0;
            if (n == p || n == other) continue;
            const int16_t *v = f->values + 4 * (size_t)n;
            sum += (int64_t)*weight * (f->table[entry(v, new)] - f->table[entry(v, old)]);
        }
        if (++y == job->height) y = 0;
    }
    return sum;
}

/* The value (rank + 1/2) / texels, rounded down to BN_VECTOR_BITS bits. */
static int16_t reduced_vector(const bn_anneal_job *job, uint32_t rank) {
    return (int16_t)(((uint64_t)rank * 2 + 1) * (1 << BN_VECTOR_BITS) /
                     ((uint64_t)job->texels * 2));
}

/* Swaps the channels in a bit set between p and q unless that raises the energy by more than `allowance`. */
static void try_vector_swap(field *f, uint32_t p, uint32_t q, uint32_t channels, double allowance) {
    bn_anneal_job *job = f->job;
    int16_t *vp = f->values + 4 * (size_t)p, *vq = f->values + 4 * (size_t)q;
    int16_t new_p[4], new_q[4];
    for (uint32_t c = 0; c < 4; ++c) {
        new_p[c] = channels >> c & 1 ? vq[c] : vp[c];
        new_q[c] = channels >> c & 1 ? vp[c] : vq[c];
    }
    int64_t loss = change_vectors(f, p, q, vp, new_p) + change_vectors(f, q, p, vq, new_q);
    if ((double)loss > allowance) return;
    for (uint32_t c = 0; c < job->channels; ++c) {
        if (!(channels >> c & 1)) continue;
        uint32_t *ranks = job->ranks + (size_t)c * job->texels, rank = ranks[p];
        BN_ASSERT(f->positions[(size_t)c * job->texels + rank] == p);
        ranks[p] = ranks[q];
        ranks[q] = rank;
        f->positions[(size_t)c * job->texels + ranks[p]] = p;
        f->positions[(size_t)c * job->texels + ranks[q]] = q;
        vp[c] = new_p[c];
        vq[c] = new_q[c];
    }
}

/* Runs one sweep. Returns 0 if cancelled. */
static int run_vector_sweep(field *f, uint32_t sweep, double temperature) {
    bn_anneal_job *job = f->job;
    const uint32_t texels = job->texels, farthest = texels / 16 + 1; /* in ranks */
    for (uint32_t trial = 0; trial < texels; ++trial) {
        if (bn_anneal_cancelled(job, sweep, trial)) return 0;
        /* Bits 32 to 63 choose p, 0 to 11 the allowance, 12 and 13 the type of move, 14 its direction, and 16 to
         * 31 q. Those of `more` choose the channel and how far q is. */
        const uint64_t bits = bn_random_next(&job->random);
        const uint32_t p = (uint32_t)((bits >> 32) * texels >> 32);
        const double allowance = temperature * job->logs[bits & (BN_ANNEAL_LOG_SIZE - 1)];
        const uint32_t more = bn_random_below(&job->random, 1u << 24);
        const uint32_t channel = (more & 0xff) % job->channels;
        uint32_t q, channels = 1u << channel;
        switch (bits >> 12 & 3) {
        case 0: /* swaps one channel with a texel of similar rank */
        case 1: {
            const uint32_t step = 1 + (uint32_t)((uint64_t)(more >> 8) * farthest >> 16);
            const uint32_t rank = job->ranks[(size_t)channel * texels + p];
            if (bits >> 14 & 1 ? rank < step : step >= texels - rank) continue;
            q = f->positions[(size_t)channel * texels +
                             (bits >> 14 & 1 ? rank - step : rank + step)];
            break;
        }
        case 2: /* swaps one channel with a texel nearby */
            q = bn_anneal_neighbour(job, p, (more >> 8) % 49);
            break;
        default: /* swaps all channels with any texel */
            q = (uint32_t)((bits >> 16 & 0xffff) * texels >> 16);
            channels = 15; /* absent ones are 0 in both texels */
            break;
        }
        if (q != p) try_vector_swap(f, p, q, channels, allowance);
    }
    return 1;
}

/* |v|^(channels / 2) from |v|^2, using only square roots, which are exact on every machine. */
static double power(double square, uint32_t channels) {
    double distance = sqrt(square);
    if (channels == 2) return distance;
    return channels == 3 ? distance * sqrt(distance) : square;
}

bn_result bn_anneal_vector(bn_anneal_job *job) {
    const bn_anneal_options *o = job->options;
    const uint32_t columns = 2 * job->reach[0] + 1, rows = 2 * job->reach[1] + 1;
    bn_result result = BN_ERROR_OUT_OF_MEMORY;
    field *f = bn_allocate_zero(1, sizeof *f);
    if (f == NULL) return result;
    f->job = job;
    f->values = bn_allocate_zero(job->texels, 4 * sizeof *f->values);
    f->positions = bn_allocate(job->texels, job->channels * sizeof *f->positions);
    f->weights = bn_allocate((size_t)columns * rows, sizeof *f->weights);
    if (f->values == NULL || f->positions == NULL || f->weights == NULL) goto done;
    double sum = 0;
    for (uint32_t y = 0; y < rows; ++y) {
        for (uint32_t x = 0; x < columns; ++x) {
            double dx = (double)x - job->reach[0], dy = (double)y - job->reach[1];
            double w = bn_portable_exp(-(dx * dx + dy * dy) / (4 * o->sigma * o->sigma));
            f->weights[y * columns + x] = (int32_t)(BN_VECTOR_ONE * w);
            sum += w;
        }
    }
    for (int i = 0; i <= BN_VECTOR_TABLE; ++i) {
        double d = power((i + 0.5) * 4 / BN_VECTOR_TABLE, job->channels);
        double exponent = d / (o->value_sigma * o->value_sigma);
        f->table[i] = exponent > 30 ? 0 : (int32_t)(BN_VECTOR_ONE * bn_portable_exp(-exponent));
    }
    for (uint32_t c = 0; c < job->channels; ++c) {
        for (uint32_t p = 0; p < job->texels; ++p) {
            const uint32_t rank = job->ranks[(size_t)c * job->texels + p];
            f->values[4 * (size_t)p + c] = reduced_vector(job, rank);
            f->positions[(size_t)c * job->texels + rank] = p;
        }
    }
    const double most = sum * BN_VECTOR_ONE * BN_VECTOR_ONE;
    result = BN_SUCCESS;
    for (uint32_t s = 0; s < o->sweeps && result == BN_SUCCESS; ++s) {
        if (!run_vector_sweep(f, s, most * bn_anneal_temperature(job, s)))
            result = BN_ERROR_CANCELLED;
    }
done:
    bn_free(f->values);
    bn_free(f->positions);
    bn_free(f->weights);
    bn_free(f);
    return result;
}
