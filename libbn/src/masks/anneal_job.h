/* SPDX-License-Identifier: Apache-2.0
 * The state and functions that single-channel and multi-channel annealing share. */
#ifndef BN_ANNEAL_JOB_H
#define BN_ANNEAL_JOB_H

#include "base/assert.h"
#include "base/portable_math.h"
#include "base/random.h"

enum {
    BN_ANNEAL_LOG_SIZE = 4096,    /* a trial spends 12 random bits on its allowance */
    BN_ANNEAL_INTERVAL = 1 << 14, /* trials between two calls of `progress`: a few milliseconds */
};

typedef struct bn_anneal_job {
    const bn_anneal_options *options;
    bn_progress progress;
    void *progress_user;
    uint32_t width, height, channels;
    uint32_t texels;
    uint32_t reach[2];  /* a window has 2 reach + 1 texels along x and y, at most the mask's */
    uint32_t *ranks;    /* [channels][texels], annealed in place */
    const double *logs; /* -ln((i + 0.5) / BN_ANNEAL_LOG_SIZE) */
    bn_random random;
} bn_anneal_job;

/* Improve a job's ranks. Errors: OUT_OF_MEMORY, CANCELLED. */
bn_result bn_anneal_scalar(bn_anneal_job *job);
bn_result bn_anneal_vector(bn_anneal_job *job);

/* A sweep's temperature, as a fraction of the largest gain. */
static inline double bn_anneal_temperature(const bn_anneal_job *job, uint32_t sweep) {
    const bn_anneal_options *o = job->options;
    BN_ASSERT(sweep < o->sweeps);
    double t = (sweep + 0.5) / o->sweeps;
    return o->start_temperature *
           bn_portable_exp(t * bn_portable_log(o->end_temperature / o->start_temperature));
}

/* Reports progress every BN_ANNEAL_INTERVAL trials; returns whether to stop. */
static inline int bn_anneal_cancelled(const bn_anneal_job *job, uint32_t sweep, uint32_t trial) {
    if (trial % BN_ANNEAL_INTERVAL != 0 || job->progress == NULL) return 0;
    const double done = (sweep + (double)trial / job->texels) / job->options->sweeps;
    return job->progress(job->progress_user, done) != 0;
}

/* A texel at most three texels from p along each axis, possibly p itself. `choice` is below 49. */
static inline uint32_t bn_anneal_neighbour(const bn_anneal_job *job, uint32_t p, uint32_t choice) {
    BN_ASSERT(p < job->texels && choice < 49);
    uint32_t x = (p % job->width + 3 * job->width + choice % 7 - 3) % job->width;
    uint32_t y = (p / job->width + 3 * job->height + choice / 7 - 3) % job->height;
    return y * job->width + x;
}

/* The offset from one coordinate to another, taking the shorter way around the torus. */
static inline int32_t bn_anneal_offset(uint32_t from, uint32_t to, uint32_t extent) {
    BN_ASSERT(from < extent && to < extent);
    int32_t d = (int32_t)to - (int32_t)from, half = (int32_t)(extent / 2);
    return d > half ? d - (int32_t)extent : d < -half ? d + (int32_t)extent : d;
}

#endif
