/* SPDX-License-Identifier: Apache-2.0
 * What rngInit(), rngNextBounce() and rand1() to rand4() of examples/web/package must draw: what bn_path.h
 * hands out in C. Writes the cases for test_random.py into a folder, as 32-bit words:
 *
 *     words.bin     [BN_WORD_COUNT]: of bn_tables()
 *     asked.bin     [cases][8]: x, y, index, bounce, effect, two words of a seed, zero
 *     expected.bin  [cases][16]: ten floats and six zeros
 *
 * Built twice: RANDOM_WITH_LENS is 0 for a renderer without a lens, and 1 for one that has it. */
#include "../c/check.h"
#include "../c/samplers.h"
#include <bn/bn_path.h>
#include <stdio.h>
#include <string.h>

enum { ASKED = 8, EXPECTED = 16, CASES = 4096 };
/* Effects with a place in the layout. Without RANDOM_WITH_LENS, those of the lens, the environment and the
 * choice are names as all others are. */
enum { PIXEL = 0, DIRECTION = 3, LENS = 4, LIGHT = 5, CHOICE = 6, ENVIRONMENT = 7 };

static void copy(float *out, const float *from, size_t count) {
    memcpy(out, from, count * sizeof *out);
}

/* The layout of paths.md, with bn_path.h alone. */
static void expect(const bn_sampler *sampler, const uint32_t *asked, float *out) {
    const int lens = RANDOM_WITH_LENS;
    const uint32_t bounce = asked[3], effect = asked[4];
    const bn_path path = bn_path_start((int32_t)asked[0], (int32_t)asked[1], asked[2], 0);
    const bn_ray ray = bn_path_ray(&path, bounce), next = bn_path_ray(&path, bounce + 1);
    const bn_ray keyed = bn_ray_keyed(&ray, effect), light = bn_ray_keyed(&ray, LIGHT);
    float u[4], v[4];
    bn_ray_draw(sampler, &keyed, u);
    bn_sample_pair(sampler, (int32_t)asked[0], (int32_t)asked[1], asked[2], keyed.domain, 2, v);
    out[0] = v[0];
    copy(out + 1, u, 2);
    copy(out + 3, u, 3);
    copy(out + 6, u, 4);
    if (effect == DIRECTION) bn_ray_draw_where(sampler, &next, out + 1);
    if (effect == PIXEL && bounce == 0) bn_ray_draw_where(sampler, &ray, out + 1);
    if (effect == LENS && bounce == 0 && lens) {
        bn_ray_draw_light(sampler, &ray, out + 1);
        copy(out + 3, out + 1, 2);
        out[5] = out[0];
    }
    if (effect == LIGHT || (effect == ENVIRONMENT && lens)) {
        if (lens && bounce == 0)
            bn_path_first_light(sampler, &path, 1, 0, out + 1);
        else
            bn_ray_draw_light(sampler, &ray, out + 1);
    }
    if (effect == LIGHT) {
        out[3] = u[2];
        copy(out + 4, u, 2);
    }
    if (effect == CHOICE && lens) {
        bn_ray_draw(sampler, &light, v);
        out[0] = v[3];
    }
}

static void ask(uint32_t number, uint32_t *asked) {
    static const uint32_t bounces[] = {0, 0, 0, 1, 2, 3, 4, 50};
    static const uint32_t indices[] = {0, 1, 2, 5, 64, 255, 256, 1000, 1u << 20, UINT32_MAX};
    const uint32_t hash = number * 0x9e3779b9u ^ number >> 5;
    asked[0] = number % 7 ? hash >> 20 : 0u - number;
    asked[1] = hash & 1023u;
    asked[2] = indices[number % 10];
    asked[3] = bounces[number / 10 % 8];
    asked[4] = number % 3 ? number / 3 % 9 : 50 + (hash >> number % 32);
}

static void put(const char *folder, const char *name, const void *data, size_t size) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    CHECK(file != NULL && fwrite(data, 1, size, file) == size && fclose(file) == 0);
}

int main(int count, char **arguments) {
    static uint32_t all_asked[CASES][ASKED];
    static float all_expected[CASES][EXPECTED];
    const bn_sampler sampler = make_sampler(BN_SAMPLER_BLUE, 0, UINT64_MAX);
    if (count != 2) return 2;
    for (uint32_t i = 0; i < CASES; ++i) {
        ask(i, all_asked[i]);
        bn_sampler_seed(&sampler, all_asked[i] + 5);
        expect(&sampler, all_asked[i], all_expected[i]);
    }
    put(arguments[1], "words.bin", bn_tables(NULL, NULL), BN_WORD_COUNT * sizeof(uint32_t));
    put(arguments[1], "asked.bin", all_asked, sizeof all_asked);
    put(arguments[1], "expected.bin", all_expected, sizeof all_expected);
    return check_result();
}
