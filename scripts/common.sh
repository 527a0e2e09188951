# SPDX-License-Identifier: Apache-2.0
# Shared functions; the other scripts set `program` and then source this file.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s: %s\n' "$program" "$*"; }

# Prints one line that says what is wrong and what to do, and exits.
die() {
    printf '%s: %s\n' "$program" "$*" >&2
    exit 1
}

# A compiler needs about a gigabyte, so machines with little memory run fewer than they have cores.
job_count() {
    local cores memory_gib
    cores=$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 1)
    memory_gib=$(awk '/^MemAvailable/ {print int($2 / 1048576)}' /proc/meminfo 2>/dev/null || true)
    [ -n "$memory_gib" ] || memory_gib=$cores
    if [ "$memory_gib" -lt "$cores" ]; then cores=$memory_gib; fi
    if [ "$cores" -lt 1 ]; then cores=1; fi
    echo "$cores"
}

# run_logged "description" command...: runs quietly; on failure shows the last lines of its output,
# shown_lines of them (default 30).
run_logged() {
    local status=0
    say "$1"
    shift
    mkdir -p "$root/out"
    "$@" >"$root/out/setup.log" 2>&1 </dev/null || status=$?
    [ "$status" -eq 0 ] || tail -n "${shown_lines:-30}" "$root/out/setup.log" >&2
    return "$status"
}
