/* SPDX-License-Identifier: Apache-2.0
 * Domains: 32-bit hashes that identify the decisions along a path. */
#include <bn/bn_draw.h>

uint32_t bn_domain_child(uint32_t domain, uint32_t key) {
    return bn_draw_domain_child(domain, key);
}
