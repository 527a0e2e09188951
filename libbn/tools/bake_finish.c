/* SPDX-License-Identifier: Apache-2.0
 * The last stage of bn_bake_sampler: what changes nothing that the search looked at.
 *
 * Below the sixteenth digit each coordinate of a point gets random sums of its upper digits, a linear
 * scrambling that keeps every net, so that points differ in all 32 digits. And the coordinates of a
 * pair change places in some members: in one domain two coordinates of different pairs are related
 * more closely or less, depending on which, at up to 8 samples; over the four members every place
 * has each relation once. In members 0 and 2 dimension 2 is then the one that fills boxes of 2^a x
 * 2^b x 2^c better together with the first pair: there it is a time beside a position, or a choice
 * and then a point. The first pair of member 0 stays as it is, for it knows rows from columns. */
#include "bake_tile.h"
#include <string.h>

static void exchange(pole_vectors *v, int pair) {
    for (int k = 0; k < POLE_VECTORS; ++k) {
        uint32_t *u = pole_vector(v, k) + 2 * pair;
        uint32_t first = u[0];
        u[0] = u[1];
        u[1] = first;
    }
}

static void exchange_coordinates(bake_table *table) {
    for (int member = 0; member < MEMBERS; ++member) {
        if (!(member & 1)) exchange(&table->member[member], 1);
        if (member & 2) exchange(&table->member[member], 0);
    }
    uint16_t third[PIXELS];
    memcpy(third, table->single[2], sizeof third);
    memcpy(table->single[2], table->single[3], sizeof third);
    memcpy(table->single[3], third, sizeof third);
}

void bake_finish(bake_table *table, const bake_options *options, int member, int number) {
    (void)number;
    bake_random r = bake_random_make(options->seed, 9, 0);
    for (member = 0; member < MEMBERS; ++member) {
        pole_vectors *v = &table->member[member];
        for (int d = 0; d < 4; ++d) {
            for (int to = POLE_DIGITS; to < 32; ++to) {
                for (int from = 0; from < to; ++from) {
                    if (bake_random_below(&r, 2)) pole_add_digit(v, d, from, to);
                }
            }
        }
    }
    exchange_coordinates(table);
}
