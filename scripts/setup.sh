# Installs the tools and libraries to build sphecs. Sourced by the other scripts in the root of the repository.
# Sets the array FEATURES to the cargo options for this machine.

say() { printf '== %s\n' "$*"; }

if ! command -v cargo >/dev/null; then
    echo "cargo is not installed: get Rust from https://rustup.rs, then run this again" >&2
    exit 1
fi

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; elif command -v sudo >/dev/null; then sudo -n "$@"; else return 1; fi
}

# Updates the package lists once per script.
install_packages() {
    command -v apt-get >/dev/null || return 1
    if [ -z "${PACKAGE_LISTS_FRESH:-}" ]; then
        as_root apt-get update -qq || return 1
        PACKAGE_LISTS_FRESH=1
    fi
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null
}

has_netcdf() {
    command -v nc-config >/dev/null && [ -f "$(nc-config --includedir)/netcdf.h" ]
}

# Creates a virtual environment in the repository; nothing is installed into the system's Python.
make_venv() {
    [ -x .venv/bin/pip ] && return 0
    command -v python3 >/dev/null || install_packages python3 python3-venv || return 1
    python3 -m venv .venv 2>/dev/null && return 0
    rm -rf .venv
    install_packages python3-venv && python3 -m venv .venv
}

# Building netcdf-c and HDF5 needs cmake ≥ 3.26, which Debian 12 lacks and PyPI has.
new_cmake() {
    local version
    version=$(cmake --version 2>/dev/null | sed -n 's/^cmake version //p')
    [ -n "$version" ] && [ "$(printf '%s\n' 3.26 "$version" | sort -V | head -1)" = 3.26 ] && return 0
    make_venv && .venv/bin/pip install --quiet 'cmake>=3.26,<4' && PATH="$PWD/.venv/bin:$PATH"
}

if ! command -v cc >/dev/null; then
    say "installing a C toolchain, which Rust needs for linking"
    install_packages build-essential || { echo "no C compiler: install gcc and libc6-dev" >&2; exit 1; }
fi

FEATURES=()
if ! has_netcdf; then
    say "installing libnetcdf-dev"
    if ! { install_packages libnetcdf-dev && has_netcdf; }; then
        say "libnetcdf-dev cannot be installed here: building netcdf-c and HDF5 from source"
        command -v make >/dev/null || install_packages build-essential || true
        new_cmake || { echo "cmake 3.26 or later is needed to build netcdf-c: install it, or libnetcdf-dev" >&2; exit 1; }
        FEATURES=(--features static)
    fi
fi
