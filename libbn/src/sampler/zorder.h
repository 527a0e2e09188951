/* SPDX-License-Identifier: Apache-2.0
 * The draws of kind ZORDER: both pairs, or only those whose bit is set in `pairs`. */
#ifndef BN_ZORDER_H
#define BN_ZORDER_H

#include "sampler/sampler_object.h"

void bn_draw_zorder(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, uint32_t pairs, uint32_t out[4]);

#endif
