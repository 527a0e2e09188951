/* SPDX-License-Identifier: Apache-2.0
 * The learned steps of bn_relax: data/relax.json in integers, written by libbn/tools/make_relax.py.
 * GROUPS: the most of a step. PAIRS: of all steps. `limit`: 1 at the scale before the step. */
#ifndef BN_RELAX_SCHEDULE_H
#define BN_RELAX_SCHEDULE_H

#include <stdint.h>

enum {
    BN_RELAX_LEARNED_STEPS = 9,
    BN_RELAX_LEARNED_GROUPS = 8,
    BN_RELAX_LEARNED_PAIRS = 292,
    BN_RELAX_LEARNED_REACH = 3
};

/* Up to eight offsets, (+-x, +-y) and (+-y, +-x), with 0 <= y <= x. */
typedef struct bn_relax_learned_group {
    int16_t x, y, weight;
} bn_relax_learned_group;

typedef struct bn_relax_learned_step {
    int16_t limit, shift; /* the shift makes the limit use all 16 bits */
    int32_t keep;         /* times 2^15 */
    uint32_t group_count;
    bn_relax_learned_group groups[BN_RELAX_LEARNED_GROUPS];
} bn_relax_learned_step;

/* clang-format off */
static const bn_relax_learned_step bn_relax_learned_steps[BN_RELAX_LEARNED_STEPS] = {
    {8192, 1, -539, 3, {{1, 0, -5937}, {1, 1, -4050}, {2, 0, 6125}}},
    {5768, 2, 973, 3, {{1, 0, 5977}, {1, 1, 1701}, {2, 0, -3609}}},
    {7396, 2, 701, 5, {{1, 0, 3805}, {1, 1, 1374}, {2, 0, 376}, {2, 1, -1073}, {2, 2, -1177}}},
    {3946, 3, 7880, 5, {{1, 0, 2826}, {1, 1, 1266}, {2, 0, 298}, {2, 1, -548}, {2, 2, -971}}},
    {2530, 3, -2547, 8, {{1, 0, 4885}, {1, 1, 2759}, {2, 0, 850}, {2, 1, -121}, {2, 2, -969},
     {3, 0, -402}, {3, 1, -507}, {3, 2, -554}}},
    {1634, 4, 340, 8, {{1, 0, 3652}, {1, 1, 2253}, {2, 0, 1049}, {2, 1, 287}, {2, 2, -660},
     {3, 0, -109}, {3, 1, -412}, {3, 2, -512}}},
    {698, 5, -3147, 8, {{1, 0, 4004}, {1, 1, 3014}, {2, 0, 981}, {2, 1, 756}, {2, 2, 230},
     {3, 0, -57}, {3, 1, -222}, {3, 2, -308}}},
    {841, 5, 922, 8, {{1, 0, 1818}, {1, 1, 1482}, {2, 0, 1477}, {2, 1, 1119}, {2, 2, 502},
     {3, 0, 630}, {3, 1, 493}, {3, 2, 279}}},
    {327, 6, -3232, 8, {{1, 0, 2621}, {1, 1, 2228}, {2, 0, 1556}, {2, 1, 1317}, {2, 2, 714},
     {3, 0, 510}, {3, 1, 434}, {3, 2, 214}}},
};
/* clang-format on */

#endif
