/* SPDX-License-Identifier: Apache-2.0
 * Results, version and domains. */
#include "check.h"
#include <bn/bn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void test_strings(void) {
    for (bn_result a = -2; a < 12; ++a) {
        CHECK(bn_result_string(a) != NULL && bn_result_string(a)[0] != '\0');
        for (bn_result b = 0; b < a && a <= BN_ERROR_CANCELLED; ++b) {
            CHECK(strcmp(bn_result_string(a), bn_result_string(b)) != 0);
        }
    }
    char version[64];
    snprintf(version, sizeof version, "%d.%d.%d", BN_VERSION_MAJOR, BN_VERSION_MINOR,
             BN_VERSION_PATCH);
    CHECK(strcmp(version, bn_version_string()) == 0);
}

static int compare_u32(const void *a, const void *b) {
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* 2^17 domains of a three-level tree: by the birthday bound 2.0 of their 2^33 pairs are expected to
 * share a 32-bit value; Poisson(2) exceeds 12 with probability 1e-7. */
static void test_domains(void) {
    enum { count = 1 << 17 };
    uint32_t *domains = malloc(count * sizeof *domains);
    int n = 0, collisions = 0;
    for (uint32_t a = 0; a < 32; ++a) {
        for (uint32_t b = 0; b < 64; ++b) {
            for (uint32_t c = 0; c < 64; ++c) {
                uint32_t d = bn_domain_child(BN_DOMAIN_ROOT, a);
                domains[n++] = bn_domain_child(bn_domain_child(d, b), c);
            }
        }
    }
    qsort(domains, count, sizeof *domains, compare_u32);
    for (int i = 1; i < count; ++i) collisions += domains[i] == domains[i - 1];
    CHECK(collisions <= 12);
    free(domains);
    CHECK(bn_domain_child(0, 1) != bn_domain_child(1, 0));
    CHECK(bn_domain_child(BN_DOMAIN_ROOT, 0) != BN_DOMAIN_ROOT);
}

int main(void) {
    test_strings();
    test_domains();
    return check_result();
}
