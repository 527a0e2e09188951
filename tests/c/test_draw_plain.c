/* SPDX-License-Identifier: Apache-2.0
 * bn_draw.h without SSE2, as on other machines, draws the same bits as the library. */
#define BN_DRAW_PLAIN
#include "check.h"
#include "samplers.h"
#include <bn/bn_draw.h>
#include <string.h>

int main(void) {
    for (int32_t kind = 0; kind < KINDS; ++kind) {
        const bn_sampler s = make_sampler(kind, 0, 6);
        uint32_t domain = BN_DOMAIN_ROOT;
        for (uint32_t i = 0; i < 20000; ++i) {
            uint32_t index = i % 3 == 0 ? i % 256u : i % 3 == 1 ? i : i * 0x9e3779b1u;
            int32_t x = (int32_t)bn_hash32(i), y = (int32_t)bn_hash32(i + 1u);
            uint32_t bits[4], plain_bits[4];
            float floats[4], plain[4];
            CHECK(bn_domain_child(domain, i) == bn_draw_domain_child(domain, i));
            domain = bn_draw_domain_child(domain, i);
            bn_sample_4d_u32(&s, x, y, index, domain, bits);
            bn_sample_4d(&s, x, y, index, domain, floats);
            bn_inline_sample_4d_u32(&s, x, y, index, domain, plain_bits);
            bn_inline_sample_4d(&s, x, y, index, domain, plain);
            CHECK(memcmp(bits, plain_bits, sizeof bits) == 0);
            CHECK(memcmp(floats, plain, sizeof floats) == 0);
            for (uint32_t pair = 0; pair < 2u; ++pair) {
                bn_inline_sample_pair(&s, x, y, index, domain, pair, plain);
                CHECK(memcmp(floats + 2u * pair, plain, sizeof floats / 2) == 0);
            }
        }
    }
    return check_result();
}
