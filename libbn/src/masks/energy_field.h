/* SPDX-License-Identifier: Apache-2.0
 * Creates energy fields and locates texels in them. simd/field.h describes the data. */
#ifndef BN_ENERGY_FIELD_H
#define BN_ENERGY_FIELD_H

#include "simd/field.h"

/* Makes a field with no texel set. Its energies are small random numbers that break ties. No extent
 * may be zero. Returns 0 if out of memory; call bn_field_destroy() in any case. */
int bn_field_create(bn_field *field, const uint32_t extent[3], double sigma, uint64_t seed);
void bn_field_destroy(bn_field *field);

/* Recomputes all extremes. */
void bn_field_refresh(bn_field *field);

/* Convert a texel to its linear index in a row-major array, and back. */
size_t bn_field_index(const bn_field *field, bn_field_texel texel);
bn_field_texel bn_field_at(const bn_field *field, size_t index);

#endif
