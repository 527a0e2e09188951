/* SPDX-License-Identifier: Apache-2.0
 * The number of CPUs that the process may use: bn_thread_count() follows the affinity mask, and the limits of
 * control groups are read from folders that the test writes. */
#define _GNU_SOURCE
#include "base/processors.h"
#include "check.h"
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char root[] = "/tmp/libbn-processors-XXXXXX";

/* Writes a file below the root, and the folders that contain it. */
static void put(const char *name, const char *text) {
    char path[512];
    snprintf(path, sizeof path, "%s%s", root, name);
    for (char *at = path + strlen(root) + 1; (at = strchr(at, '/')) != NULL; *at++ = '/') {
        *at = 0;
        mkdir(path, 0700);
    }
    FILE *file = fopen(path, "w");
    CHECK(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
}

static void remove_all(void) {
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", root);
    CHECK(system(command) == 0);
}

static void test_groups(void) {
    static const struct {
        const char *groups; /* /proc/self/cgroup */
        struct {
            const char *name, *text;
        } files[3];
        uint32_t limit;
    } cases[] = {
        {"0::/\n", {{"cpu.max", "150000 100000\n"}}, 2},
        {"0::/\n", {{"cpu.max", "max 100000\n"}}, UINT32_MAX},
        {"0::/\n", {{"cpu.max", "1000 100000\n"}}, 1},
        {"0::/\n", {{NULL, NULL}}, UINT32_MAX},
        /* Every group above counts, and a folder without a limit does not. */
        {"0::/a/b/c\n", {{"a/cpu.max", "300000 100000\n"}, {"a/b/cpu.max", "max 100000\n"}}, 3},
        {"0::/a/b\n", {{"a/cpu.max", "300000 100000\n"}, {"a/b/cpu.max", "400000 50000\n"}}, 3},
        /* A container that sees the path of its group on the host. */
        {"0::/docker/0123\n", {{"cpu.max", "400000 100000\n"}}, 4},
        /* Version 1, where other controllers have paths of their own. */
        {"4:cpuset:/\n3:cpu,cpuacct:/job\n2:memory:/other\n",
         {{"cpu/job/cpu.cfs_quota_us", "250000\n"}, {"cpu/job/cpu.cfs_period_us", "100000\n"}},
         3},
        {"3:cpuacct,cpu:/job\n0::/\n",
         {{"cpu/cpu.cfs_quota_us", "500000\n"}, {"cpu/cpu.cfs_period_us", "100000\n"}},
         5},
        {"3:cpu:/\n",
         {{"cpu/cpu.cfs_quota_us", "-1\n"}, {"cpu/cpu.cfs_period_us", "100000\n"}},
         UINT32_MAX},
        {"3:cpuset,cpuacct:/\n",
         {{"cpu/cpu.cfs_quota_us", "100000\n"}, {"cpu/cpu.cfs_period_us", "100000\n"}},
         UINT32_MAX},
        {"", {{NULL, NULL}}, UINT32_MAX},
        {"no colons\n::\n", {{NULL, NULL}}, UINT32_MAX},
        {"0::/\n", {{"cpu.max", "nonsense"}}, UINT32_MAX},
        {"0::/\n", {{"cpu.max", "100000 0\n"}}, UINT32_MAX},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        strcpy(root + strlen(root) - 6, "XXXXXX");
        CHECK(mkdtemp(root) != NULL);
        put("/proc/self/cgroup", cases[i].groups);
        for (size_t f = 0; f < 3 && cases[i].files[f].name != NULL; ++f) {
            char name[128];
            snprintf(name, sizeof name, "/sys/fs/cgroup/%s", cases[i].files[f].name);
            put(name, cases[i].files[f].text);
        }
        const uint32_t limit = bn_processors_granted(root);
        if (limit != cases[i].limit) printf("case %zu: %u\n", i, limit);
        CHECK(limit == cases[i].limit);
        remove_all();
    }
    CHECK(bn_processors_granted("/nonexistent") == UINT32_MAX);
}

static void test_affinity(void) {
    cpu_set_t all, one;
    CHECK(sched_getaffinity(0, sizeof all, &all) == 0);
    const uint32_t here = (uint32_t)CPU_COUNT(&all), granted = bn_processors_granted("");
    CHECK(bn_thread_count() == (here < granted ? here : granted));
    int cpu = 0;
    while (!CPU_ISSET(cpu, &all)) ++cpu;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    CHECK(sched_setaffinity(0, sizeof one, &one) == 0);
    CHECK(bn_thread_count() == 1);
}

int main(void) {
    test_groups();
    test_affinity();
    return check_result();
}
