/* SPDX-License-Identifier: Apache-2.0
 * The ends of bn_bake_sampler: what the search begins with, and below the sixteenth digit of each
 * coordinate random sums of its upper digits, a linear scrambling that keeps every net, so that
 * points differ in all 32 digits. */
#include "bake_tile.h"

void bake_start(bake_table *table, const bake_options *options, int member, int number) {
    (void)number;
    for (member = 0; member < MEMBERS; ++member) {
        pole_vectors_make(&table->member[member], member);
        bake_tree_labels(table->label[member], bake_mix(options->seed),
                         bake_mix(options->seed + 1000 * (uint64_t)(member + 1)), member != 0);
    }
}

void bake_finish(bake_table *table, const bake_options *options, int member, int number) {
    (void)number;
    bake_random r = bake_random_make(options->seed, 9, 0);
    for (member = 0; member < MEMBERS; ++member) {
        pole_vectors *v = &table->member[member];
        for (int d = 0; d < 4; ++d) {
            for (int to = 16; to < 32; ++to) {
                for (int from = 0; from < to; ++from) {
                    if (bake_random_below(&r, 2)) pole_add_digit(v, d, from, to);
                }
            }
        }
    }
}
