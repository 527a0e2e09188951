// SPDX-License-Identifier: Apache-2.0
// The program.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>

#include "commands.h"
#include "error.h"
#include "sampler.h"
#include "scene.h"

namespace {

// Opens /dev/null for each standard stream that is closed. Otherwise a picture could get the
// stream's number, and then its text too.
void occupy_closed_streams() {
    for (int descriptor = 0; descriptor < 3; ++descriptor)
        if (fcntl(descriptor, F_GETFD) < 0) open("/dev/null", O_RDONLY);
}

constexpr double GIB = 1024.0 * 1024 * 1024;

// Bytes of such memory already taken, which under sanitizers is terabytes that are never touched.
double taken() {
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    for (int field = 0; field < 6; ++field) file >> pages; // the sixth: data and stack
    return file ? pages * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
}

// From here on, allocations beyond this many GiB, by default half of the machine's, fail, those of
// libraries and threads too: a scene made to waste memory ends in one line and not with the
// machine's. 0 is no bound. Works on Linux from 4.7 on; elsewhere some systems do without.
void limit_memory(std::optional<double> chosen) {
    const double half = 0.5 * static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
                        static_cast<double>(sysconf(_SC_PAGESIZE)) / GIB;
    const double gib = chosen.value_or(half);
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

// The exit status of a run that went well, if all that it printed has arrived.
int status_of_output() {
    const bool failed = std::ferror(stdout) != 0;
    if (std::fflush(stdout) == 0 && !failed) return 0;
    say(std::string("cannot write to standard output: ") +
        (failed ? "not all of it arrived" : std::strerror(errno)));
    return 1;
}

void print_list() {
    std::printf("scenes:\n");
    for (const SceneEntry &entry : scene_entries())
        std::printf("  %-10s %s\n", entry.name, entry.summary);
    std::printf("samplers:\n");
    int width = 10;
    for (const SamplerEntry &entry : sampler_entries())
        width = std::max(width, static_cast<int>(std::strlen(entry.name)));
    for (const SamplerEntry &entry : sampler_entries())
        std::printf("  %-*s %s\n", width, entry.name, entry.summary);
}

void print_cameras(const Options &options) {
    std::fputs(camera_list(scene_build(options.scene, scene_options(options))).c_str(), stdout);
}

} // namespace

int main(int argc, char **argv) {
    occupy_closed_streams();
    exit_where_it_would_abort();
#ifdef SIGXFSZ
    // Treat a file size limit as an error, like a full disk, instead of dying with half a file.
    std::signal(SIGXFSZ, SIG_IGN);
#endif
    try {
        const Options options = parse_options(argc, argv);
        limit_memory(options.max_memory);
        if (options.help) {
            std::fputs(options_help(), stdout);
        } else if (options.list) {
            print_list();
        } else if (options.list_cameras) {
            print_cameras(options);
        } else if (options.list_inputs) {
            std::fputs(input_list(options).c_str(), stdout);
        } else if (!options.merge.empty()) {
            run_merge(options);
        } else {
            const int signal = run_render(options);
            // The shell's convention: a script sees that the picture is incomplete.
            if (signal) return 128 + signal;
        }
        return status_of_output();
    } catch (const std::bad_alloc &) {
        say("out of memory; render the picture in parts with --crop, or allow more with "
            "--max-memory");
    } catch (const std::exception &error) {
        say(error.what());
    }
    return 1;
}
