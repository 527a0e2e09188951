// SPDX-License-Identifier: Apache-2.0
// Nanoseconds per four-dimensional draw on one core, as CSV on standard output: sampler,form,nanoseconds.
//
//     bench_draws [NAME=PLUGIN ...]
//
// A path's draws are made pixel by pixel, with 16 indices per pixel and six decisions per index: `single` calls the
// library's bn_sample_4d() or a plug-in (sampler_plugin.h), `inline` the inline function in bn_draw.h, and `peer`
// OpenQMC as its README recommends (-DBN_OPENQMC=DIR): one sampler for each pixel and index, newDomain() for each
// decision, and drawSample(). `block` makes as many draws without decisions, with bn_sample_block().
//
// Two forms make the same draws for the lanes of a wavefront, whose arguments and results are arrays: `lanes` calls
// bn_sample_4d() for each lane, and `many` calls bn_sample_wavefront() once. BN_SIMD selects the instruction set.
//
// Each time is the minimum of ROUNDS short, interleaved measurements, so that other jobs have no effect. In each
// round, a form runs twice, and its first run warms the caches.
#include <bn/bn.h>

// Calls the library's function, before bn_path.h replaces it with an inline function.
static void call_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, float out[4]) {
    bn_sample_4d(sampler, x, y, index, domain, out);
}

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <vector>

#include "files.h"
#include "plugin.h"

#ifdef BN_WITH_OPENQMC
#include <oqmc/latticebn.h>
#include <oqmc/pmjbn.h>
#include <oqmc/sobolbn.h>
#endif

namespace {

constexpr uint32_t WIDTH = 64, HEIGHT = 4, INDICES = 16, DECISIONS = 6, ROUNDS = 400;
constexpr uint32_t DRAWS = WIDTH * HEIGHT * INDICES * DECISIONS;

struct Row {
    std::string sampler;
    const char *form;
    std::function<float(int32_t y0)> draw; // returns what depends on every draw
    double best = 1e30;
};

// The draws of a path: start(x, y, index) returns a function (decision, out). A function of its own for each form, so
// that its machine code does not depend on the others.
template <typename Start>
[[gnu::noinline]] float paths(int32_t y0, const Start &start) {
    float sum = 0;
    for (int32_t y = y0; y < y0 + int32_t(HEIGHT); ++y)
        for (int32_t x = 0; x < int32_t(WIDTH); ++x)
            for (uint32_t index = 0; index < INDICES; ++index) {
                const auto draw = start(x, y, index);
                for (uint32_t decision = 0; decision < DECISIONS; ++decision) {
                    float u[4] = {};
                    draw(decision, u);
                    sum += u[0] + u[1] + u[2] + u[3];
                }
            }
    return sum;
}

// The results, and the arguments of all draws as arrays.
struct Arrays {
    float u[4 * DRAWS];
    int32_t x[DRAWS], y[DRAWS];
    uint32_t index[DRAWS], domain[DRAWS];

    Arrays() {
        for (uint32_t i = 0; i < DRAWS; ++i) {
            const uint32_t pixel = i / DECISIONS / INDICES;
            x[i] = int32_t(pixel % WIDTH);
            y[i] = int32_t(pixel / WIDTH);
            index[i] = i / DECISIONS % INDICES;
            domain[i] = bn_domain_child(BN_DOMAIN_ROOT, i % DECISIONS);
        }
    }
    float ends() const { return u[0] + u[4 * DRAWS - 1]; }
} arrays;

void require(bn_result result) {
    if (result != BN_SUCCESS) throw Error(bn_result_string(result));
}

float block(const bn_sampler &sampler, int32_t y0) {
    require(bn_sample_block(&sampler, 0, y0, WIDTH, HEIGHT * DECISIONS, 0, INDICES, 1, arrays.u,
                            4 * DRAWS));
    return arrays.ends();
}

float lanes(const bn_sampler &sampler) {
    for (size_t i = 0; i < DRAWS; ++i)
        call_4d(&sampler, arrays.x[i], arrays.y[i], arrays.index[i], arrays.domain[i],
                arrays.u + 4 * i);
    return arrays.ends();
}

float many(const bn_sampler &sampler) {
    bn_wavefront all = bn_wavefront_default();
    all.count = DRAWS;
    all.x = arrays.x;
    all.y = arrays.y;
    all.index = arrays.index;
    all.domain = arrays.domain;
    for (int d = 0; d < 4; ++d) all.out[d] = arrays.u + d;
    all.stride = 4;
    require(bn_sample_wavefront(&sampler, &all));
    return arrays.ends();
}

void add_library(std::vector<Row> &rows) {
    const char *const names[] = {"blue", "sobol", "white", "zorder", "mask"};
    for (int32_t type = 0; type < 5; ++type) {
        bn_sampler sampler;
        require(bn_sampler_init(&sampler, type, 0));
        const auto add = [&](const char *form, auto draw) {
            rows.push_back({names[type], form, draw});
        };
        add("single", [sampler](int32_t y0) {
            return paths(y0, [&](int32_t x, int32_t y, uint32_t index) {
                return [=, &sampler](uint32_t key, float *u) {
                    call_4d(&sampler, x, y, index, bn_domain_child(BN_DOMAIN_ROOT, key), u);
                };
            });
        });
        add("block", [sampler](int32_t y0) { return block(sampler, y0); });
        add("lanes", [sampler](int32_t) { return lanes(sampler); });
        add("many", [sampler](int32_t) { return many(sampler); });
        if (type > BN_SAMPLER_WHITE)
            continue; // the inline functions of the others call the library
        add("inline", [sampler](int32_t y0) {
            return paths(y0, [&](int32_t x, int32_t y, uint32_t index) {
                return [=, &sampler](uint32_t key, float *u) {
                    bn_draw_4d(&sampler, x, y, index, bn_draw_domain_child(BN_DOMAIN_ROOT, key), u);
                };
            });
        });
    }
}

void add_plugin(std::vector<Row> &rows, const std::string &name, const Plugin &plugin) {
    rows.push_back({name, "single", [plugin](int32_t y0) {
                        return paths(y0, [&](int32_t x, int32_t y, uint32_t index) {
                            return [=, &plugin](uint32_t ray, float *u) {
                                plugin.draw(plugin.state.get(), plugin.seed, x, y, index,
                                            PluginPath::ray_decision(ray), 4, u);
                            };
                        });
                    }});
}

#ifdef BN_WITH_OPENQMC
template <typename Sampler>
void add_openqmc(std::vector<Row> &rows, const char *name) {
    std::vector<char> tables(Sampler::cacheSize);
    Sampler::initialiseCache(tables.data());
    rows.push_back({name, "peer", [tables](int32_t y0) {
                        return paths(y0, [&](int32_t x, int32_t y, uint32_t index) {
                            return [root = Sampler(x, y, 0, int(index), tables.data())](
                                       uint32_t key, float *u) {
                                root.newDomain(int(key)).template drawSample<4>(u);
                            };
                        });
                    }});
}
#endif

int run(int argc, char **argv) {
    std::vector<Row> rows;
    add_library(rows);
#ifdef BN_WITH_OPENQMC
    add_openqmc<oqmc::PmjBnSampler>(rows, "openqmc-pmjbn");
    add_openqmc<oqmc::SobolBnSampler>(rows, "openqmc-sobolbn");
    add_openqmc<oqmc::LatticeBnSampler>(rows, "openqmc-latticebn");
#endif
    for (int i = 1; i < argc; ++i) {
        const std::string given = argv[i];
        const size_t name = given.find('=');
        add_plugin(rows, given.substr(0, name), plugin_load(given.substr(name + 1), 0, 0));
    }
    volatile float sink;
    for (uint32_t round = 0; round < ROUNDS; ++round)
        for (size_t i = 0; i < 2 * rows.size(); ++i) {
            Row &row = rows[i / 2];
            const auto start = std::chrono::steady_clock::now();
            sink = row.draw(int32_t(round % 16 * HEIGHT));
            const std::chrono::duration<double, std::nano> used =
                std::chrono::steady_clock::now() - start;
            row.best = std::min(row.best, used.count() / DRAWS);
        }
    (void)sink;
    std::puts("sampler,form,nanoseconds");
    for (const Row &row : rows)
        std::printf("%s,%s,%.2f\n", row.sampler.c_str(), row.form, row.best);
    return 0;
}

} // namespace

int main(int argc, char **argv) {
    return run_or_say(run, argc, argv);
}
