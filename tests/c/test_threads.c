/* SPDX-License-Identifier: Apache-2.0
 * Threads share samplers and generate masks at the same time. Their results do not depend on the order of
 * the calls. Under the thread sanitizer, the test also detects data races. */
#include "check.h"
#include "samplers.h"
#include <bn/bn.h>
#include <pthread.h>
#include <string.h>

enum { THREADS = 4, SIZE = 24, SAMPLES = 320, MASK = 32, BLOCK = SIZE * 300 * 4 };

typedef struct job {
    const bn_sampler *samplers;
    uint32_t number; /* the thread's number, which determines the order of its draws */
    uint64_t hash[TYPES];
    uint32_t cluster[MASK * MASK], relaxed[MASK * MASK];
    float block[BLOCK];
    int failures;
} job;

static uint64_t mixed(uint64_t hash, uint64_t value) {
    return (hash ^ value) * 0x9e3779b97f4a7c15u;
}

/* Draws every sample of a small image in a different order on each thread. The hash is a sum, so it does not
 * depend on this order. */
static void *work(void *argument) {
    static const uint32_t strides[THREADS + 1] = {1, 7, 11, 13, 17}; /* coprime to the total */
    job *j = argument;
    for (int type = 0; type < TYPES; ++type) {
        const bn_sampler *s = &j->samplers[type];
        for (uint32_t k = 0; k < SIZE * SAMPLES; ++k) {
            uint32_t at = (k * strides[j->number] + 77u * j->number) % (SIZE * SAMPLES);
            uint32_t u[4], domain = bn_domain_child(at % 7u, 3u);
            int32_t x = (int32_t)(at % SIZE) - 5;
            bn_sample_4d_u32(s, x, -x, at / SIZE, domain, u);
            for (uint32_t d = 0; d < 4; ++d) j->hash[type] += mixed(at * 4u + d, u[d]);
        }
        j->failures +=
            bn_sample_block(s, -5, 9, SIZE, 1, 0, 300, 2u, j->block, BLOCK) != BN_SUCCESS;
        for (size_t i = 0; i < BLOCK; ++i) {
            j->hash[type] += mixed(i, bits_of(j->block[i]));
        }
    }
    const bn_mask cluster = bn_mask_u32(j->cluster, MASK, MASK);
    const bn_mask relaxed = bn_mask_u32(j->relaxed, MASK, MASK);
    j->failures += bn_void_and_cluster(NULL, &cluster, NULL, NULL) != BN_SUCCESS;
    j->failures += bn_relax(NULL, &relaxed, NULL, NULL) != BN_SUCCESS;
    return NULL;
}

int main(void) {
    static job jobs[THREADS + 1];
    bn_sampler samplers[TYPES];
    pthread_t threads[THREADS];
    for (int32_t type = 0; type < TYPES; ++type) {
        samplers[type] = make_sampler(type, 0, 4);
    }
    for (uint32_t i = 0; i <= THREADS; ++i) {
        jobs[i].samplers = samplers;
        jobs[i].number = i;
    }
    work(&jobs[0]); /* on this thread alone */
    for (uint32_t i = 0; i < THREADS; ++i) {
        CHECK(pthread_create(&threads[i], NULL, work, &jobs[i + 1]) == 0);
    }
    for (uint32_t i = 0; i < THREADS; ++i) pthread_join(threads[i], NULL);
    for (int i = 0; i <= THREADS; ++i) {
        CHECK(jobs[i].failures == 0);
        CHECK(memcmp(jobs[i].hash, jobs[0].hash, sizeof jobs[0].hash) == 0);
        CHECK(memcmp(jobs[i].cluster, jobs[0].cluster, sizeof jobs[0].cluster) == 0);
        CHECK(memcmp(jobs[i].relaxed, jobs[0].relaxed, sizeof jobs[0].relaxed) == 0);
    }
    return check_result();
}
