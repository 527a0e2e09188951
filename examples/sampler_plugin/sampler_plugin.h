/* SPDX-License-Identifier: Apache-2.0
 * The interface of a sampler in a shared library. The path tracer loads it with --sampler ./FILE.so, and the benchmarks
 * with --sampler NAME=./FILE.so; both use plugin.h. evidence/plugins and docs/bench.md have samples. C99, also C++; other
 * languages export the same functions. You choose its licence.
 *
 *     cc -O2 -shared -fPIC -I examples/sampler_plugin mine.c -o mine.so
 *
 * A decision is a group of numbers that a path needs in one place, numbered 4 * slot + part:
 *
 *     slot  part  numbers
 *     0     0     4  pixel position; lens, or the light where the camera's ray ends
 *     3     0     4  the light where the camera's ray ends, in place of slot 0's; time and wavelength
 *     s     0     4  ray s (1, 2) or ray s - 1 (s > 3) of the path: direction; the light where it ends
 *     s     2     2  the same ray: lobe of rough glass; Russian roulette
 *
 * A loop, such as the flight through fog, adds (loop + 1) * 2^14 to the decision of its ray, part 0. The ray's n-th
 * further pair of part 2 adds n * 2^24. A sequence that serves whole paths need not spend dimensions on these: use
 * independent numbers. */
#ifndef SAMPLER_PLUGIN_H
#define SAMPLER_PLUGIN_H

#include <stdint.h>

#define SAMPLER_PLUGIN_VERSION 1u

#ifdef __cplusplus
#define SAMPLER_PLUGIN_EXPORT extern "C" __attribute__((visibility("default")))
#else
#define SAMPLER_PLUGIN_EXPORT extern __attribute__((visibility("default")))
#endif

/* Required: returns SAMPLER_PLUGIN_VERSION. */
SAMPLER_PLUGIN_EXPORT uint32_t sampler_plugin_version(void);

/* Required: writes the first `dimensions` numbers of a decision, each in [0, 1), for sample `index` of pixel (x, y).
 * A number outside [0, 1) ends the program with an error. The same arguments must always give the same numbers, in any
 * order and from several threads at once.
 *
 *   state       from sampler_plugin_create(), or NULL
 *   seed, x, y  any, also negative; images with different seeds should be independent
 *   index       below 2^31; images with different sample counts share their first samples
 *   dimensions  2 or 4; both start with the same two numbers */
SAMPLER_PLUGIN_EXPORT void sampler_plugin_draw(const void *state, uint64_t seed, int32_t x,
                                               int32_t y, uint32_t index, uint32_t decision,
                                               uint32_t dimensions, float *out);

/* Optional: two numbers for part k of a sample that is split into `count` parts, such as several light samples of
 * one path. Without it, part k has the numbers of sample index * count + k. */
SAMPLER_PLUGIN_EXPORT void sampler_plugin_split(const void *state, uint64_t seed, int32_t x,
                                                int32_t y, uint32_t index, uint32_t decision,
                                                uint32_t count, uint32_t k, float *out);

/* Optional: a state for a seed, such as tables. `samples` is the number of samples per pixel, or 0 if unknown, and
 * `argument` the text after the file's name (./FILE.so:TEXT), or "". Returns NULL to reject them. */
SAMPLER_PLUGIN_EXPORT void *sampler_plugin_create(uint64_t seed, uint32_t samples,
                                                  const char *argument);
SAMPLER_PLUGIN_EXPORT void sampler_plugin_destroy(void *state);

/* Optional: returns 1 if draws depend on `samples`. The benchmarks then render each sample count separately. */
SAMPLER_PLUGIN_EXPORT uint32_t sampler_plugin_is_tuned(void);

#endif
