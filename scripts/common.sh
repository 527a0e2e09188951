# SPDX-License-Identifier: Apache-2.0
# What the scripts share; sourced by setup, demo, test and format after they set `program`.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s: %s\n' "$program" "$*"; }

# One line that says what was wrong and what to do; nothing goes on after it.
die() {
    printf '%s: %s\n' "$program" "$*" >&2
    exit 1
}

# Compilers take about a gigabyte each, so small machines get fewer at once than they have cores.
job_count() {
    local cores memory_gib
    cores=$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 1)
    memory_gib=$(awk '/^MemAvailable/ {print int($2 / 1048576)}' /proc/meminfo 2>/dev/null || true)
    [ -n "$memory_gib" ] || memory_gib=$cores
    if [ "$memory_gib" -lt "$cores" ]; then cores=$memory_gib; fi
    if [ "$cores" -lt 1 ]; then cores=1; fi
    echo "$cores"
}

# run_logged "what is done" command...: quiet; when it fails, the end of what the command printed is shown,
# shown_lines of it (default 30).
run_logged() {
    local status=0
    say "$1"
    shift
    mkdir -p "$root/out"
    "$@" >"$root/out/setup.log" 2>&1 </dev/null || status=$?
    [ "$status" -eq 0 ] || tail -n "${shown_lines:-30}" "$root/out/setup.log" >&2
    return "$status"
}
