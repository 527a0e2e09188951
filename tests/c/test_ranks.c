/* SPDX-License-Identifier: Apache-2.0
 * Converts values to ranks and ranks to values. */
#include "check.h"
#include "masks.h"
#include <math.h>

/* Ranks are correct if values sorted by rank ascend and tied values keep their order. */
static int are_ranks(const float *values, size_t count, const uint32_t *ranks) {
    if (!is_permutation(ranks, count)) return 0;
    uint32_t *at = malloc(count * sizeof *at);
    size_t wrong = 0;
    for (size_t i = 0; i < count; ++i) at[ranks[i]] = (uint32_t)i;
    for (size_t r = 1; r < count; ++r) {
        const float before = values[at[r - 1]], value = values[at[r]];
        wrong += !(before < value || (before == value && at[r - 1] < at[r]));
    }
    free(at);
    return wrong == 0;
}

/* Arbitrary floats, and floats with few distinct values so that many are tied. */
static void test_many_values(void) {
    static const size_t counts[] = {1, 2, 2047, 2049, 1 << 20};
    enum { most = 1 << 20 };
    float *values = malloc(most * sizeof *values);
    uint32_t *ranks = malloc(most * sizeof *ranks), state = 5;
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        for (int few = 0; few < 2; ++few) {
            for (size_t i = 0; i < counts[c]; ++i) {
                uint32_t bits = few ? (next_random(&state) & 511u) << 23 : next_random(&state);
                if ((bits & 0x7fffffffu) > 0x7f800000u) bits &= 0xff7fffffu; /* no NaN */
                values[i] = float_of(bits);
            }
            CHECK(bn_ranks_from_values(values, counts[c], ranks) == BN_SUCCESS);
            CHECK(are_ranks(values, counts[c], ranks));
        }
    }
    free(values);
    free(ranks);
}

static void test_bad_input(void) {
    float values[3] = {1, NAN, 2};
    uint32_t ranks[3] = {7, 7, 7};
    CHECK(bn_ranks_from_values(values, 3, ranks) == BN_ERROR_BAD_DATA);
    values[1] = -NAN;
    CHECK(bn_ranks_from_values(values, 3, ranks) == BN_ERROR_BAD_DATA);
    CHECK(bn_ranks_from_values(NULL, 3, ranks) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_ranks_from_values(values, 3, NULL) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_ranks_from_values(values, 0, ranks) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(ranks[0] == 7 && ranks[1] == 7 && ranks[2] == 7);
}

static void test_to_float(void) {
    CHECK(bn_rank_to_float(0, 1) == 0.5f);
    CHECK(bn_rank_to_float(1, 2) == 0.75f);
    CHECK(bn_rank_to_float(9, 2) == 0.75f);
    CHECK(bn_rank_to_float(3, 0) == 0.0f);
    static const size_t counts[] = {3, 4096, 65536, 1u << 24, (1u << 24) + 1, UINT32_MAX};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        uint32_t state = 3;
        for (int i = 0; i < 10000; ++i) {
            uint32_t rank = (uint32_t)(next_random(&state) % counts[c]);
            if (i == 0) rank = (uint32_t)(counts[c] - 1);
            float value = bn_rank_to_float(rank, counts[c]);
            double exact = (rank + 0.5) / (double)counts[c];
            /* The exact value is rounded down to a float and never becomes 1. */
            CHECK(value >= 0 && value < 1 && (double)value <= exact);
            CHECK((double)nextafterf(value, 2) > exact || value == 1 - 0x1p-24f);
        }
    }
}

int main(void) {
    test_many_values();
    test_bad_input();
    test_to_float();
    return check_result();
}
