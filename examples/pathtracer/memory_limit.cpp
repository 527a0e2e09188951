// SPDX-License-Identifier: Apache-2.0
// The system's own limit of a process's data: memory that it can write and shares with nobody.
#include "memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace {

constexpr double GIB = 1024.0 * 1024 * 1024;

// Bytes of such memory already taken, which under sanitizers is terabytes that are never touched.
double taken() {
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    for (int field = 0; field < 6; ++field) file >> pages; // the sixth: data and stack
    return file ? pages * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
}

} // namespace

double memory_default() {
    const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0
               ? 0.5 * static_cast<double>(pages) * static_cast<double>(size) / GIB
               : 0;
}

void memory_limit(double gib) {
    if (!(gib > 0)) return;
    rlimit limit;
    if (getrlimit(RLIMIT_DATA, &limit) != 0) return;
    const double bytes = taken() + gib * GIB;
    // A bound that is lower already stays.
    if (limit.rlim_cur != RLIM_INFINITY && static_cast<double>(limit.rlim_cur) <= bytes) return;
    limit.rlim_cur = static_cast<rlim_t>(bytes);
    if (limit.rlim_max != RLIM_INFINITY) limit.rlim_cur = std::min(limit.rlim_cur, limit.rlim_max);
    setrlimit(RLIMIT_DATA, &limit);
}
