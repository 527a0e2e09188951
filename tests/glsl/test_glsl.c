/* SPDX-License-Identifier: Apache-2.0
 * bn_draw.glsl, compiled as C, gives the bits of bn_draw.h. That it is GLSL as well is checked by
 * glslangValidator where that is installed. */
#include "../c/check.h"
#include "glsl_in_c.h"
#include <string.h>

static const bn_draw_table *table;

#define BN_PIXEL(i) table->pixels[i]
#define BN_DIGIT_X(i) table->digits.x[i]
#define BN_DIGIT_Y(i) table->digits.y[i]
#define BN_SEED_LOW table->seed[0]
#define BN_SEED_HIGH table->seed[1]
#define BN_SIZE_LOG2 table->size_log2

/* In C a literal like 1.0 is of double precision, as scale is not. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#endif
#include <bn/bn_draw.glsl>

#undef float
#undef uint

static void compare(int32_t kind, int32_t x, int32_t y, uint32_t index, uint32_t domain) {
    uint32_t bits[4];
    float floats[4];
    uvec4 u;
    vec4 f;
    bn_draw_4d_u32(table, x, y, index, domain, bits);
    bn_draw_4d(table, x, y, index, domain, floats);
    if (kind == BN_SAMPLER_BLUE) {
        u = bn_draw_blue_u32((uint32_t)x, (uint32_t)y, index, domain);
        f = bn_draw_blue_glsl((uint32_t)x, (uint32_t)y, index, domain);
    } else if (kind == BN_SAMPLER_SOBOL) {
        u = bn_draw_sobol_u32((uint32_t)x, (uint32_t)y, index, domain);
        f = bn_draw_sobol_glsl((uint32_t)x, (uint32_t)y, index, domain);
    } else {
        u = bn_draw_white_u32((uint32_t)x, (uint32_t)y, index, domain);
        f = bn_draw_white_glsl((uint32_t)x, (uint32_t)y, index, domain);
    }
    CHECK(memcmp(&u, bits, sizeof bits) == 0);
    CHECK(memcmp(&f, floats, sizeof floats) == 0);
}

int main(void) {
    static const int32_t coordinates[] = {0, 5, -1, 127, 128, -129, INT32_MAX, INT32_MIN};
    static const uint32_t indices[] = {0,   1,   2,   3,    30,       64,         200,
                                       255, 256, 257, 1000, 1u << 20, UINT32_MAX, 0x80000001u};
    enum { NC = sizeof coordinates / sizeof *coordinates, NI = sizeof indices / sizeof *indices };
    for (int32_t kind = BN_SAMPLER_BLUE; kind <= BN_SAMPLER_WHITE; ++kind) {
        for (uint64_t seed = 0; seed < 8; ++seed) {
            bn_sampler_options options = bn_sampler_options_default();
            bn_sampler *sampler = NULL;
            options.kind = kind;
            options.seed = seed;
            CHECK(bn_sampler_create(&options, &sampler) == BN_SUCCESS);
            table = bn_sampler_table(sampler);
            uint32_t domain = (uint32_t)seed;
            for (int i = 0; i < NC * NC * NI; ++i) {
                uint32_t child = bn_draw_domain_child(domain, (uint32_t)i);
                CHECK(bn_domain_child_glsl(domain, (uint32_t)i) == child);
                domain = child;
                compare(kind, coordinates[i % NC], coordinates[i / NC % NC], indices[i / NC / NC],
                        domain);
            }
            bn_sampler_destroy(sampler);
        }
    }
    return check_result();
}
