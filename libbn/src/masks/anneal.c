/* SPDX-License-Identifier: Apache-2.0
 * Simulated annealing of masks (Georgiev and Fajardo, "Blue-noise dithered sampling", 2016): checks
 * the arguments, makes the initial mask and chooses the energy. Takes sweeps x texels trials.
 *
 * A trial swaps two texels' ranks if the energy falls, or if it rises by at most the temperature times
 * -ln of a random number (Metropolis's rule). The logarithms come from a table, because the C library's
 * differ between systems. The temperature falls geometrically, once per sweep. */
#include "base/check.h"
#include "base/float_environment.h"
#include "base/memory.h"
#include "base/options.h"
#include "masks/anneal_job.h"
#include "masks/eliminate.h"
#include <float.h>

/* The window's radius in sigmas, at which the kernel exp(-d^2 / (4 sigma^2)) has fallen to 0.3%. */
static const double BN_ANNEAL_CUTOFF = 4.8;

/* The distance in sigmas beyond which texels with the same value do not interact. */
static const double BN_ANNEAL_SPARSE = 10.0 / 3;

static int good_anneal_options(const bn_anneal_options *o, uint32_t channels) {
    const int has_far = channels == 1 && o->far_weight != 0; /* <windows.h> defines far */
    return bn_in_range(o->sigma, 0.25, 4) && (!has_far || bn_in_range(o->far_sigma, o->sigma, 4)) &&
           bn_in_range(o->far_weight, 0, DBL_MAX) && bn_in_range(o->value_sigma, 0.01, 100) &&
           bn_in_range(o->start_temperature, DBL_TRUE_MIN, 1) &&
           bn_in_range(o->end_temperature, DBL_TRUE_MIN, o->start_temperature);
}

/* The initial void-and-cluster run always reports a progress of 0. */
static int32_t at_start(void *user, double fraction) {
    const bn_anneal_job *job = user;
    (void)fraction;
    return job->progress(job->progress_user, 0);
}

/* Fills job->ranks with the caller's ranks or with void-and-cluster masks. */
static bn_result start(bn_anneal_job *job, const bn_mask *mask) {
    for (uint32_t c = 0; c < job->channels; ++c) {
        uint32_t *ranks = job->ranks + (size_t)c * job->texels;
        bn_result result;
        if (job->options->start_from_ranks) {
            const bn_mask channel = bn_mask_channel(mask, c);
            result = bn_check_mask(&channel);
            for (size_t i = 0; i < job->texels && result == BN_SUCCESS; ++i)
                ranks[i] = bn_mask_rank(&channel, i);
        } else {
            const bn_mask channel = bn_mask_u32(ranks, job->width, job->height);
            bn_void_and_cluster_options v = bn_void_and_cluster_options_default();
            v.seed = bn_mix64(job->options->seed + c);
            result =
                bn_void_and_cluster(&v, &channel, job->progress != NULL ? at_start : NULL, job);
        }
        if (result != BN_SUCCESS) return result;
    }
    return BN_SUCCESS;
}

static BN_NOINLINE bn_result anneal(const bn_anneal_options *given, const bn_mask *mask,
                                    bn_progress progress, void *progress_user) {
    bn_anneal_options o = bn_anneal_options_default();
    size_t count;
    bn_result result = bn_options_read(&o, sizeof o, given);
    if (result == BN_SUCCESS) result = bn_check_new_mask(mask, &count);
    if (result != BN_SUCCESS) return result;
    if (mask->depth != 1 || mask->channels > 4 || !good_anneal_options(&o, mask->channels))
        return BN_ERROR_INVALID_ARGUMENT;

    const uint32_t width = mask->width, height = mask->height, channels = mask->channels;
    const size_t texels = count / channels;
    bn_anneal_job job = {.options = &o,
                         .progress = progress,
                         .progress_user = progress_user,
                         .width = width,
                         .height = height,
                         .channels = channels,
                         .texels = (uint32_t)texels,
                         .random = bn_random_seeded(o.seed)};
    const double sigma = channels == 1 && o.far_weight > 0 ? o.far_sigma : o.sigma;
    for (int axis = 0; axis < 2; ++axis) { /* a window must not contain a texel twice */
        const uint32_t most = ((axis == 0 ? width : height) - 1) / 2;
        job.reach[axis] = (uint32_t)(BN_ANNEAL_CUTOFF * sigma);
        if (job.reach[axis] > most) job.reach[axis] = most;
        BN_ASSERT(2 * job.reach[axis] < (axis == 0 ? width : height));
    }
    double *logs = bn_allocate(BN_ANNEAL_LOG_SIZE, sizeof *logs);
    job.ranks = bn_allocate(count, sizeof *job.ranks);
    if (logs == NULL || job.ranks == NULL) {
        result = BN_ERROR_OUT_OF_MEMORY;
        goto done;
    }
    for (int i = 0; i < BN_ANNEAL_LOG_SIZE; ++i) {
        logs[i] = -bn_portable_log((i + 0.5) / BN_ANNEAL_LOG_SIZE);
    }
    job.logs = logs;
    result = start(&job, mask);
    /* A texel without neighbours cannot be improved. */
    if (result == BN_SUCCESS && job.reach[0] + job.reach[1] > 0) {
        result = channels == 1 ? bn_anneal_scalar(&job) : bn_anneal_vector(&job);
    }
    const uint32_t extent[3] = {width, height, 1};
    if (result == BN_SUCCESS && channels == 1 && o.order_ends)
        result = bn_eliminate_ends(extent, BN_ANNEAL_SPARSE * sigma, o.seed, 1, job.ranks, texels,
                                   1, NULL, NULL);
    if (result == BN_SUCCESS) bn_mask_write(mask, job.ranks, count);
done:
    bn_free(logs);
    bn_free(job.ranks);
    return result;
}

bn_result bn_anneal(const bn_anneal_options *options, const bn_mask *mask, bn_progress progress,
                    void *progress_user) {
    BN_RETURN_IN_DEFAULT_ENVIRONMENT(anneal(options, mask, progress, progress_user));
}
