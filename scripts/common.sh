# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154
# Shared functions; the other scripts set `program` and then source this file.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s: %s\n' "$program" "$*"; }

# Prints one line that says what is wrong and what to do, and exits.
die() {
    printf '%s: %s\n' "$program" "$*" >&2
    exit 1
}

# CMake, compilers and Python environments fail late and with misleading messages on some of these characters.
case $root in
    *[\#\"\;\\:\[\]\|\<\>\$]* | *[[:cntrl:]]*)
        die "cannot work in the folder $(printf %q "$root"); give it a name without # \" ; \\ : [ ] | < > $ and tabs" ;;
esac

# Each compiler process needs about a gigabyte, so machines with little memory run fewer processes than they have cores.
job_count() {
    local cores memory_gib
    cores=$(nproc 2>/dev/null || getconf _NPROCESSORS_ONLN 2>/dev/null || echo 1)
    memory_gib=$(awk '/^MemAvailable/ {print int($2 / 1048576)}' /proc/meminfo 2>/dev/null || true)
    [ -n "$memory_gib" ] || memory_gib=$cores
    if [ "$memory_gib" -lt "$cores" ]; then cores=$memory_gib; fi
    if [ "$cores" -lt 1 ]; then cores=1; fi
    echo "$cores"
}

# With ccache, no file is compiled twice, even in different folders. CMake reads these variables.
if command -v ccache >/dev/null 2>&1; then
    export CMAKE_C_COMPILER_LAUNCHER=${CMAKE_C_COMPILER_LAUNCHER-ccache}
    export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER-ccache}
fi

# run_logged "description" command...: runs quietly; on failure shows the last shown_lines lines of its
# output (default 30).
run_logged() {
    local status=0
    say "$1"
    shift
    mkdir -p "$root/out"
    "$@" >"$root/out/setup.log" 2>&1 </dev/null || status=$?
    [ "$status" -eq 0 ] || tail -n "${shown_lines:-30}" "$root/out/setup.log" >&2
    return "$status"
}

# apt_install package...: installs Debian packages; ${as_root[@]} is the command that runs others as root.
apt_install() {
    shown_lines=3 run_logged "installing Debian packages: $*" ${as_root[@]+"${as_root[@]}"} sh -c 'apt-get update;
        DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@"' sh "$@" && hash -r
}

have() { command -v "$1" >/dev/null 2>&1; }

# install_requirements -NAME "packages": installs scripts/requirements-NAME.txt ("": requirements.txt) into .venv unless they are
# installed. Python 3.11, which the continuous integration uses, gets exactly the locked versions; other versions use the ranges.
install_requirements() {
    local stamp=.venv/requirements$1.sha256 files=("scripts/requirements$1.txt" "scripts/requirements$1.lock") requirements wanted
    requirements=(-r "${files[0]}")
    if .venv/bin/python -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))'; then
        requirements=(--require-hashes -r "${files[1]}")
    fi
    wanted=$(cat "${files[@]}" | sha256sum)
    [ "$wanted" != "$(cat "$stamp" 2>/dev/null)" ] || return 0
    shown_lines=0 run_logged "installing Python packages into .venv: $2" \
        .venv/bin/python -m pip install --disable-pip-version-check "${requirements[@]}" ||
        die "cannot install Python packages (no network? see out/setup.log); run: .venv/bin/python -m pip install ${requirements[*]}"
    echo "$wanted" >"$stamp"
}
