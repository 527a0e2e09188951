/* SPDX-License-Identifier: Apache-2.0
 * The learned steps of bn_relax: data/relax.json in integers, written by libbn/tools/make_relax.py.
 * GROUPS: the most of a step. PAIRS: of all steps. `limit`: 1 at the scale before the step. */
#ifndef BN_RELAX_SCHEDULE_H
#define BN_RELAX_SCHEDULE_H

#include <stdint.h>

enum {
    BN_RELAX_LEARNED_STEPS = 9,
    BN_RELAX_LEARNED_GROUPS = 12,
    BN_RELAX_LEARNED_PAIRS = 364,
    BN_RELAX_LEARNED_REACH = 4
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
    {8192, 1, 22320, 3, {{1, 0, 2238}, {1, 1, 2203}, {2, 0, 779}}},
    {23649, 0, -2, 3, {{1, 0, 7501}, {1, 1, -711}, {2, 0, -3137}}},
    {7223, 2, -877, 5, {{1, 0, 4349}, {1, 1, 1310}, {2, 0, -411}, {2, 1, -1220}, {2, 2, -526}}},
    {1965, 4, -8123, 5, {{1, 0, 3178}, {1, 1, 1752}, {2, 0, 506}, {2, 1, -235}, {2, 2, -518}}},
    {4599, 2, -488, 8, {{1, 0, 5159}, {1, 1, 3207}, {2, 0, 414}, {2, 1, -292}, {2, 2, -879},
     {3, 0, -1273}, {3, 1, -1006}, {3, 2, -423}}},
    {1118, 4, 2784, 8, {{1, 0, 4907}, {1, 1, 3154}, {2, 0, 1187}, {2, 1, 508}, {2, 2, -517},
     {3, 0, -651}, {3, 1, -538}, {3, 2, -605}}},
    {1264, 4, 3416, 12, {{1, 0, 3124}, {1, 1, 2318}, {2, 0, 1144}, {2, 1, 731}, {2, 2, 141},
     {3, 0, -223}, {3, 1, -330}, {3, 2, -388}, {4, 0, -475}, {4, 1, -373}, {3, 3, -358},
     {4, 2, -229}}},
    {349, 6, 2759, 12, {{1, 0, 3006}, {1, 1, 2408}, {2, 0, 1483}, {2, 1, 1131}, {2, 2, 416},
     {3, 0, 288}, {3, 1, 166}, {3, 2, -75}, {4, 0, -30}, {4, 1, -121}, {3, 3, -124},
     {4, 2, -121}}},
    {234, 7, -896, 12, {{1, 0, 1586}, {1, 1, 1372}, {2, 0, 1015}, {2, 1, 885}, {2, 2, 558},
     {3, 0, 471}, {3, 1, 402}, {3, 2, 258}, {4, 0, 151}, {4, 1, 121}, {3, 3, 104}, {4, 2, 54}}},
};
/* clang-format on */

#endif
