/* SPDX-License-Identifier: Apache-2.0
 * Finds mistakes in an integration of libbn. Link it with two functions of your renderer, sampler() and draw();
 * docs/porting.md explains the output. In a C++ renderer, declare both extern "C" or compile this file as C++. */
#include <bn/bn_path.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Your renderer's sampler. */
const bn_sampler *sampler(void);
/* The numbers that your renderer draws for sample `index` of pixel (x, y): u[0] and u[1] for decision 0, the
   position in the pixel, or for decision 1, any other 2-D decision. If decision 1 depends on a choice made with a
   number of its own, such as a lobe or a light, u[2] is that number. Record all of them as drawn, before any
   mapping. */
void draw(int x, int y, unsigned index, int decision, float u[3]);

enum { SIZE = 128, WINDOW = 16 };
static const double AREA = 0.7853982; /* of a quarter disc: the expected share of samples in it */
static double error[2][SIZE][SIZE];   /* of the number of samples in it */
/* Samples whose u[0], or u[1], is in the same half of [0, 1) as u[2]. */
static int halves[2][SIZE][SIZE];

/* The error after a blur, divided by the error of white noise after the same blur. */
static double blurred(unsigned count) {
    double squares = 0;
    int windows = 0;
    for (int y = 0; y <= SIZE - WINDOW; y += WINDOW / 2)
        for (int x = 0; x <= SIZE - WINDOW; x += WINDOW / 2)
            for (int d = 0; d < 2; ++d, ++windows) {
                double sum = 0;
                for (int i = 0; i < WINDOW; ++i)
                    for (int j = 0; j < WINDOW; ++j)
                        sum += (8 - abs(2 * i - 15) / 2) * (8 - abs(2 * j - 15) / 2) *
                               error[d][y + i][x + j];
                squares += sum * sum;
            }
    return sqrt(squares / windows / (408.0 * 408 * AREA * (1 - AREA) * count));
}

/* The stream of your renderer's paths: the first one from which its first pixel position could come, or 0. */
static unsigned stream(void) {
    float u[3], v[2];
    draw(0, 0, 0, 0, u);
    for (unsigned s = 0; s < 1u << 20; ++s) {
        const bn_path path = bn_path_start(0, 0, 0, s);
        const bn_ray ray = bn_path_ray(&path, 0);
        bn_ray_draw_direction(sampler(), &ray, v);
        if (u[0] == v[0] && u[1] == v[1]) return s;
    }
    return 0;
}

int main(void) {
    const unsigned of_paths = stream();
    double product = 0, square = 0;
    int repeats = 0, first = 0, apart = 0;
    for (unsigned index = 0; index < 16; ++index) {
        for (int pixel = 0; pixel < SIZE * SIZE; ++pixel)
            for (int d = 0; d < 2; ++d) {
                float u[3] = {0};
                draw(pixel % SIZE, pixel / SIZE, index, d, u);
                error[d][pixel / SIZE][pixel % SIZE] += (u[0] * u[0] + u[1] * u[1] < 1) - AREA;
                for (int i = 0; i < 2; ++i)
                    if (d == 1)
                        halves[i][pixel / SIZE][pixel % SIZE] += (u[i] < 0.5f) == (u[2] < 0.5f);
            }
        if (index == 0 || index == 3 || index == 15)
            printf("%2u spp  %.2f\n", index + 1, blurred(index + 1));
    }
    for (int pixel = 0; pixel < SIZE * SIZE; ++pixel) {
        const int x = pixel % SIZE, y = pixel / SIZE;
        float u[3], v[3];
        draw(x, y, 0, 0, u);
        for (int step = 8; step <= 64; step *= 2) {
            draw(x + step, y, 0, 0, v);
            repeats += u[0] == v[0] && u[1] == v[1];
        }
        const bn_path path = bn_path_start(x, y, 0, of_paths);
        const bn_ray ray = bn_path_ray(&path, 0);
        bn_ray_draw_direction(sampler(), &ray, v);
        first += u[0] == v[0] && u[1] == v[1];
        apart += halves[0][y][x] != 8 || halves[1][y][x] != 8;
        product += error[0][y][x] * error[1][y][x];
        square += error[0][y][x] * error[0][y][x];
    }
    printf("repeats %d\nshared  %.2f\n", repeats, product / square);
    printf("first   %.2f\napart   %.2f\n", first / (double)(SIZE * SIZE),
           apart / (double)(SIZE * SIZE));
    return 0;
}
