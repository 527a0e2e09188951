/* SPDX-License-Identifier: Apache-2.0
 * A renderer for examples/check/check.c that makes the mistake MISTAKE. SEED is the sampler's seed. LAYOUT selects what
 * decision 1 draws: by default numbers 0, 1 and 2 of the next ray's domain; with "second pair", numbers 2 and 3 of
 * decision 0's domain; with "grandchild", numbers of a domain two levels below the root. */
#include <bn/bn_path.h>
#include <stdlib.h>
#include <string.h>

const bn_sampler *sampler(void);
void draw(int x, int y, unsigned index, int decision, float u[3]);

static const char *mistake, *layout;
static bn_sampler made;

static const char *setting(const char *name, const char *otherwise) {
    const char *value = getenv(name);
    return value != NULL ? value : otherwise;
}

static int is(const char *name) {
    return strcmp(mistake, name) == 0;
}

const bn_sampler *sampler(void) {
    if (mistake != NULL) return &made;
    const int32_t types[] = {BN_SAMPLER_BLUE, BN_SAMPLER_SOBOL, BN_SAMPLER_WHITE};
    mistake = setting("MISTAKE", "none");
    layout = setting("LAYOUT", "next ray");
    bn_sampler_init(&made,
                    types[is("sobol")   ? 1
                          : is("white") ? 2
                                        : 0],
                    strtoull(setting("SEED", "0"), NULL, 10));
    return &made;
}

void draw(int x, int y, unsigned index, int decision, float u[3]) {
    const bn_sampler *own = sampler();
    const int second_pair = decision == 1 && strcmp(layout, "second pair") == 0;
    const uint32_t key = is("shared domain") || second_pair ? 0 : (uint32_t)decision;
    uint32_t domain = bn_domain_child(BN_DOMAIN_ROOT, key);
    if (decision == 1 && strcmp(layout, "grandchild") == 0) domain = bn_domain_child(domain, 5);
    if (strcmp(layout, "stream") == 0)
        domain = bn_path_ray_domain(bn_path_start(x, y, index, 70000), key);
    const int old_x = x, old_y = y;
    if (is("index from 1")) index += 1;
    if (is("index from 1000")) index += 1000;
    if (is("index over the image")) index += 16 * (unsigned)(1000 * y + x);
    if (is("index stuck at 0")) index = 0;
    if (is("index drawn twice")) index /= 2;
    if (is("threads")) index /= 4;
    static bn_sampler of_tile;
    if (is("seed per tile")) {
        bn_sampler_init(&of_tile, BN_SAMPLER_BLUE, 1 + (uint64_t)(x / 16 + 1000 * (y / 16)));
        own = &of_tile;
    }
    if (is("domain per sample")) domain = bn_domain_child(domain, index);
    if (is("domain or seed per pixel"))
        domain = bn_domain_child(bn_domain_child(domain, (uint32_t)x), (uint32_t)y);
    if (is("pixel number")) x = 1000 * y + x, y = 0;
    if (is("tile coordinates")) x %= 16, y %= 16;
    if (is("exchanged in tiles")) {
        x = old_x / 16 * 16 + old_y % 16;
        y = old_y / 16 * 16 + old_x % 16;
    }
    float four[4], next[4];
    bn_sample_4d(own, x, y, index, domain, four);
    bn_sample_4d(own, x, y, index, bn_ray_4d_domain(domain, 0), next);
    const int swapped = second_pair || (is("lens first") && decision == 0);
    u[0] = four[swapped ? 2 : 0], u[1] = four[swapped ? 3 : 1];
    if (decision == 0 || second_pair) return;
    u[2] = is("pair first") ? next[2] : four[2];
    /* One by one, a number remaining from an earlier draw and then the lobe are requested. */
    if (is("one by one")) u[0] = four[3], u[1] = next[2];
}
