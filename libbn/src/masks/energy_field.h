/* SPDX-License-Identifier: Apache-2.0
 * Making an energy field, and finding texels in it; simd/field.h says what it holds. */
#ifndef BN_ENERGY_FIELD_H
#define BN_ENERGY_FIELD_H

#include "simd/field.h"

/* A field without a texel set, its energies small random numbers of the seed that break ties.
 * `extent` may hold zeros nowhere. Returns 0 when memory is short; destroy it in any case. */
int bn_field_create(bn_field *field, const uint32_t extent[3], double sigma, uint64_t seed);
void bn_field_destroy(bn_field *field);

/* Finds all extremes anew. */
void bn_field_refresh(bn_field *field);

/* The linear index of a texel in a row-major array, and back. */
size_t bn_field_index(const bn_field *field, bn_field_texel texel);
bn_field_texel bn_field_at(const bn_field *field, size_t index);

#endif
