/* SPDX-License-Identifier: Apache-2.0
 * Counts the CPUs that the process may use: those of its affinity mask (taskset), but no more than the CPU
 * time that its control groups grant (a container's limit). More threads than that would only wait for each
 * other: the kernel stops all of them once the group's time is used up. Reads a few files, so callers count once
 * per computation. */
#include "base/processors.h"

#if defined(__linux__)
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>
#elif defined(_WIN32)
#include "base/windows.h"
#else
#include <unistd.h>
#endif

#if defined(__linux__)

/* <unistd.h> declares it only with extensions, as <sched.h> does sched_getaffinity(). */
BN_API long syscall(long number, ...);

static uint32_t affinity_count(void) {
    static const size_t word_bits = 8 * sizeof(unsigned long);
    unsigned long mask[128] = {0};
    uint32_t count = 0;
    if (syscall(SYS_sched_getaffinity, 0, sizeof mask, mask) > 0) {
        for (size_t i = 0; i < word_bits * (sizeof mask / sizeof *mask); ++i) {
            count += (uint32_t)(mask[i / word_bits] >> i % word_bits & 1u);
        }
    } else { /* more CPUs than bits */
        const long online = sysconf(_SC_NPROCESSORS_ONLN);
        if (online > 0) count = (uint32_t)online;
    }
    return count;
}

/* Reads a short text file. Returns whether there is one. */
static int read_text(char *text, size_t size, const char *path) {
    size_t length = 0;
    const int file = open(path, O_RDONLY);
    if (file < 0) return 0;
    for (;;) {
        const ssize_t got = read(file, text + length, size - 1 - length);
        if (got <= 0) break;
        length += (size_t)got;
    }
    close(file);
    text[length] = 0;
    return length > 0;
}

/* The limit of one control group, rounded up, or 0 if it has none. The files hold microseconds: cpu.max
 * "max 100000" or "150000 100000"; in version 1, two files with the same numbers, and -1 for no limit. */
static uint32_t group_limit(const char *root, int version, const char *group) {
    char path[4352], text[64], *rest = text; /* two numbers of at most 20 digits */
    const char *files = version == 2 ? "" : "/cpu";
    snprintf(path, sizeof path, "%s/sys/fs/cgroup%s%s/%s", root, files, group,
             version == 2 ? "cpu.max" : "cpu.cfs_quota_us");
    if (!read_text(text, sizeof text, path)) return 0;
    const long quota = strtol(text, &rest, 10);
    if (version == 1) {
        snprintf(path, sizeof path, "%s/sys/fs/cgroup%s%s/cpu.cfs_period_us", root, files, group);
        if (!read_text(text, sizeof text, path)) return 0;
        rest = text;
    }
    const long period = strtol(rest, NULL, 10);
    return quota > 0 && period > 0 ? (uint32_t)((quota - 1) / period + 1) : 0;
}

/* Whether a line of /proc/self/cgroup, "5:cpu,cpuacct:/group" or "0::/group", is about CPU time, and for
 * which version. Returns the group's path, or NULL. */
static char *group_of(char *line, int *version) {
    char *names = strchr(line, ':');
    char *group = names != NULL ? strchr(names + 1, ':') : NULL;
    if (group == NULL) return NULL;
    *group++ = 0;
    *version = names[1] == 0 ? 2 : 1;
    for (char *name = names; *version == 1; ++name) {
        name = strstr(name, "cpu");
        if (name == NULL) return NULL;
        if ((name[-1] == ':' || name[-1] == ',') && (name[3] == 0 || name[3] == ',')) break;
    }
    return group;
}

uint32_t bn_processors_granted(const char *root) {
    char path[256], text[4096], *next = text;
    uint32_t least = UINT32_MAX;
    snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    if (!read_text(text, sizeof text, path)) return least;
    while (*next != 0) {
        char *line = next, *group;
        int version;
        next = line + strcspn(line, "\n");
        if (*next != 0) *next++ = 0;
        group = group_of(line, &version);
        /* Each group is also bound by the groups above it. Inside a container, only the last may be visible. */
        for (char *end = group != NULL ? group + strlen(group) : NULL; end != NULL;
             end = strrchr(group, '/')) {
            *end = 0;
            const uint32_t limit = group_limit(root, version, group);
            if (limit != 0 && limit < least) least = limit;
        }
    }
    return least;
}

uint32_t bn_thread_count(void) {
    const uint32_t affine = affinity_count(), granted = bn_processors_granted("");
    const uint32_t count = affine < granted ? affine : granted;
    return count > 0 ? count : 1;
}

#else

uint32_t bn_thread_count(void) {
    uint32_t count = 0;
#if defined(_WIN32)
    bn_windows_word mine = 0, all = 0;
    GetProcessAffinityMask(GetCurrentProcess(), &mine, &all);
    for (; mine != 0; mine &= mine - 1) ++count;
#else
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    if (online > 0) count = (uint32_t)online;
#endif
    return count > 0 ? count : 1;
}

#endif
