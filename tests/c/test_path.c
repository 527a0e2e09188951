/* SPDX-License-Identifier: Apache-2.0
 * Draws random paths through bn_path.h, including additional numbers, nested splits and loops. No two
 * decisions share a number, and no ray's numbers depend on earlier rays' draws. */
#include <bn/bn_path.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "samplers.h"

enum { PLACES = 4, MOST_NUMBERS = 4096, MOST_RAYS = 40, DEPTH = 2 };

static uint32_t random_state = 1;

static uint32_t random_below(uint32_t limit) {
    return next_random(&random_state) % limit;
}

/* One path's numbers in the order of its decisions, for each of PLACES pixels. */
static float numbers[PLACES][MOST_NUMBERS];
static int count;

static void put(int place, const float *u, int n) {
    for (int i = 0; i < n && count < MOST_NUMBERS; ++i) numbers[place][count++] = u[i];
}

/* Draws a path and its branches. random_state determines their structure. */
static void draw_path(const bn_sampler *sampler, bn_path path, uint32_t lights, int place,
                      int level) {
    const uint32_t rays = 1 + random_below(level > 0 ? 4 : MOST_RAYS);
    float u[4];
    if (random_below(2)) {
        for (uint32_t k = 0; k < lights; ++k) {
            bn_path_first_light(sampler, &path, lights, k, u);
            put(place, u, 2);
        }
    }
    if (random_below(2)) {
        bn_path_time_wavelength(sampler, &path, u);
        put(place, u, 2);
    }
    for (uint32_t number = 0; number < rays; ++number) {
        bn_ray ray = bn_path_ray(&path, number);
        uint32_t names = random_below(1000);
        bn_ray_draw(sampler, &ray, u);
        put(place, u, 4);
        for (uint32_t more = random_below(12); more > 0; --more) {
            switch (random_below(16)) {
            case 0:
                if (level < DEPTH) {
                    const uint32_t branches = random_below(5), taken = 1 + random_below(6);
                    const bn_split split = branches > 0
                                               ? bn_ray_next_split(&ray, branches)
                                               : bn_ray_next_split_from(&ray, path.index * 8);
                    for (uint32_t k = 0; k < taken; ++k)
                        draw_path(sampler, bn_split_path(&split, k), lights, place, level + 1);
                }
                break;
            case 1: {
                bn_loop noise = bn_ray_next_loop(sampler, &ray);
                for (uint32_t i = random_below(20); i > 0; --i) {
                    u[0] = bn_loop_next_1d(&noise);
                    put(place, u, 1);
                }
                break;
            }
            case 2: {
                bn_ray part = bn_ray_child(&ray, names++);
                bn_ray_draw(sampler, &part, u);
                put(place, u, 4);
                u[0] = bn_ray_next_1d(sampler, &part);
                put(place, u, 1);
                break;
            }
            case 3:
                bn_ray_next_4d(sampler, &ray, u);
                put(place, u, 4);
                break;
            default:
                if (random_below(2)) {
                    u[0] = bn_ray_next_1d(sampler, &ray);
                    put(place, u, 1);
                } else {
                    bn_ray_next_2d(sampler, &ray, u);
                    put(place, u, 2);
                }
            }
        }
    }
}

static int compare(const void *a, const void *b) {
    return memcmp(a, b, PLACES * sizeof(float));
}

/* Counts decisions that share a number in all pixels. By chance, 24 bits may be identical, but not 96. */
static int shared(void) {
    static float rows[MOST_NUMBERS][PLACES];
    int equal = 0;
    for (int i = 0; i < count; ++i)
        for (int place = 0; place < PLACES; ++place) rows[i][place] = numbers[place][i];
    qsort(rows, (size_t)count, sizeof rows[0], compare);
    for (int i = 1; i < count; ++i) equal += compare(rows[i - 1], rows[i]) == 0;
    return equal;
}

static void no_two_decisions_share_a_number(int32_t type) {
    static const int32_t x[PLACES] = {0, 70001, -5, 640}, y[PLACES] = {0, 3, -40000, 481};
    const bn_sampler sampler = make_sampler(type, 64, 7);
    int most = 0;
    for (uint32_t trial = 0; trial < 150; ++trial) {
        const uint32_t index = random_below(300), frame = random_below(3), begin = random_state;
        for (int place = 0; place < PLACES; ++place) {
            random_state = begin;
            count = 0;
            draw_path(&sampler, bn_path_start(x[place], y[place], index, frame), 1 + trial % 5,
                      place, 0);
        }
        CHECK(count > 0 && shared() == 0);
        if (count > most) most = count;
    }
    CHECK(most > 2000);
}

/* However many numbers a path draws at one ray, its next ray draws the same numbers. */
static void rays_do_not_depend_on_earlier_draws(void) {
    const bn_sampler sampler = make_sampler(BN_SAMPLER_BLUE, 0, 3);
    const bn_path path = bn_path_start(4, 5, 6, 0);
    for (uint32_t number = 0; number < MOST_RAYS; ++number) {
        bn_ray plain = bn_path_ray(&path, number + 1), other = bn_path_ray(&path, number);
        float u[4], v[4];
        for (int i = 0; i < 40; ++i)
            bn_ray_next_2d(&sampler, &other, u), (void)bn_ray_next_1d(&sampler, &other);
        other = bn_path_ray(&path, number + 1);
        bn_ray_draw(&sampler, &plain, u);
        bn_ray_draw(&sampler, &other, v);
        CHECK(memcmp(u, v, sizeof u) == 0);
        float pair[2];
        bn_ray_draw_direction(&sampler, &plain, pair);
        CHECK(pair[0] == u[0] && pair[1] == u[1]);
        bn_ray_draw_end_light(&sampler, &plain, pair);
        CHECK(pair[0] == u[2] && pair[1] == u[3]);
        /* Drawing single numbers does not affect pairs. */
        for (int i = 0; i < 5; ++i) (void)bn_ray_next_1d(&sampler, &other);
        bn_ray_next_2d(&sampler, &plain, u);
        bn_ray_next_2d(&sampler, &other, v);
        CHECK(u[0] == v[0] && u[1] == v[1]);
        /* It does not affect children, either. */
        const bn_ray part = bn_ray_child(&plain, 12), same = bn_ray_child(&other, 12);
        const bn_ray next = bn_ray_child(&plain, 13);
        bn_ray_draw(&sampler, &part, u);
        bn_ray_draw(&sampler, &same, v);
        CHECK(memcmp(u, v, sizeof u) == 0 && next.domain != part.domain);
    }
}

/* With a fixed branch count, the branches of all samples in a pixel form one sequence. */
static void split_branches_form_one_sequence(void) {
    const bn_sampler sampler = make_sampler(BN_SAMPLER_BLUE, 0, 5);
    for (uint32_t index = 0; index < 8; ++index) {
        const bn_path path = bn_path_start(17, 18, index, 0);
        bn_ray ray = bn_path_ray(&path, 1);
        const uint32_t domain = bn_domain_child(bn_ray_split_domain(ray.domain, 0), 4);
        const bn_split split = bn_ray_next_split(&ray, 4), next = bn_ray_next_split(&ray, 0);
        const bn_split running = bn_ray_next_split_from(&ray, 3 * index);
        CHECK(bn_split_path(&running, 2).index == 3 * index + 2);
        CHECK(bn_split_path(&running, 2).domain == bn_split_path(&running, 0).domain);
        CHECK(bn_split_path(&running, 0).domain != bn_split_path(&next, 0).domain);
        for (uint32_t k = 0; k < 4; ++k) {
            float u[4], v[4];
            const bn_path branch = bn_split_path(&split, k);
            const bn_ray first = bn_path_ray(&branch, 0);
            bn_ray_draw(&sampler, &first, u);
            bn_sample_4d(&sampler, 17, 18, 4 * index + k, bn_domain_child(domain, 0), v);
            CHECK(memcmp(u, v, sizeof u) == 0);
            bn_path_first_light(&sampler, &path, 4, k, u);
            bn_sample_2d(&sampler, 17, 18, 4 * index + k, bn_domain_child(BN_DOMAIN_ROOT, 3), 0, v);
            CHECK(u[0] == v[0] && u[1] == v[1]);
        }
        CHECK(bn_split_path(&next, 0).domain != bn_split_path(&split, 0).domain);
        CHECK(bn_split_path(&next, 0).index == index);
        CHECK(bn_split_path(&split, 4).domain != bn_split_path(&split, 0).domain);
        CHECK(bn_split_path(&split, 4).index == bn_split_path(&split, 0).index);
    }
}

int main(void) {
    CHECK(sizeof(bn_path) == 16);
    for (int32_t type = 0; type < TYPES; ++type) no_two_decisions_share_a_number(type);
    rays_do_not_depend_on_earlier_draws();
    split_branches_form_one_sequence();
    return check_result();
}
