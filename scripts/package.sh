#!/usr/bin/env bash
# Builds a tarball and a Debian package of the program: with shell completions, manual pages, scenes and licences.
#
#     ./scripts/package.sh [--static] [--program FILE]
#
# The files are in target/packages. --static links NetCDF and HDF5 into the program, which then needs nothing but glibc;
# without it the Debian package depends on the library of this system. --program takes a program that is built already.
set -euo pipefail
cd "$(dirname "$0")/.."

program=
static=
build=(--profile dist --locked)
while [ $# -gt 0 ]; do
    case $1 in
        --static) build+=(--features static); static=yes ;;
        --program) program=$2; shift ;;
        *) echo "unknown option $1; see the head of $0" >&2; exit 2 ;;
    esac
    shift
done
if [ -z "$program" ]; then
    . scripts/setup.sh
    if [ -n "$static" ]; then
        new_cmake || { echo "cmake 3.26 or later is needed to build netcdf-c: install it" >&2; exit 1; }
    fi
    cargo build "${build[@]}" "${FEATURES[@]}"
    program=${CARGO_TARGET_DIR:-target}/dist/sphecs
fi

version=$("$program" --version | cut -d' ' -f2)
machine=$(uname -m)
packages=$PWD/target/packages
name=sphecs-$version-$machine-linux
rm -rf "$packages"
stage=$packages/$name
mkdir -p "$stage"/{bin,man,completions}

install -m 755 "$program" "$stage/bin/sphecs"
"$program" man --dir "$stage/man"
for shell in bash zsh fish; do "$program" completions $shell >"$stage/completions/sphecs.$shell"; done
cp -r scenes README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT "$stage"
# The same bytes from the same sources: nothing depends on who packs when.
date=$(git log -1 --format=%cI 2>/dev/null || date -Iseconds)
tar --sort=name --mtime="$date" --owner=0 --group=0 --numeric-owner -C "$packages" -cf - "$name" |
    gzip -9n >"$packages/$name.tar.gz"

if ! command -v dpkg-deb >/dev/null; then
    echo "no dpkg-deb here: only $packages/$name.tar.gz was made" >&2
    exit 0
fi
root=$packages/deb
share=$root/usr/share
mkdir -p "$root"/{DEBIAN,usr/bin} "$share"/{man/man1,doc/sphecs,sphecs,bash-completion/completions} \
    "$share"/{zsh/vendor-completions,fish/vendor_completions.d}
install -m 755 "$program" "$root/usr/bin/sphecs"
cp "$stage"/man/*.1 "$share/man/man1/"
gzip -9n "$share"/man/man1/*.1
cp "$stage/completions/sphecs.bash" "$share/bash-completion/completions/sphecs"
cp "$stage/completions/sphecs.zsh" "$share/zsh/vendor-completions/_sphecs"
cp "$stage/completions/sphecs.fish" "$share/fish/vendor_completions.d/sphecs.fish"
cp -r scenes "$share/sphecs/"
cp README.md "$share/doc/sphecs/"
gzip -9nc CHANGELOG.md >"$share/doc/sphecs/changelog.gz"
{
    echo "sphecs is licensed under the MIT licence or the Apache licence 2.0, at your option."
    echo
    cat LICENSE-MIT
    echo
    cat LICENSE-APACHE
} >"$share/doc/sphecs/copyright"
# The packages of the libraries that the program is linked with.
depends=libc6
if command -v dpkg-shlibdeps >/dev/null; then
    mkdir -p "$packages/debian"
    printf 'Source: sphecs\n\nPackage: sphecs\nArchitecture: any\n' >"$packages/debian/control"
    depends=$(cd "$packages" && dpkg-shlibdeps -O "deb/usr/bin/sphecs" 2>/dev/null | sed -n 's/^shlibs:Depends=//p')
    rm -r "$packages/debian"
fi
architecture=$(dpkg --print-architecture)
cat >"$root/DEBIAN/control" <<CONTROL
Package: sphecs
Version: $version
Architecture: $architecture
Maintainer: The sphecs developers <sphecs@localhost>
Section: science
Priority: optional
Installed-Size: $(du -sk "$root/usr" | cut -f1)
Depends: $depends
Description: smoothed particle hydrodynamics with open boundaries
 Runs flows through channels, pipes and bends, past bodies and around moving
 parts from one scene file, and writes NetCDF files that xarray opens.
CONTROL
find "$root" -type d -exec chmod 755 {} +
find "$root/usr/share" -type f -exec chmod 644 {} +
dpkg-deb --root-owner-group --build "$root" "$packages/sphecs_${version}_$architecture.deb" >/dev/null
rm -r "$root"
ls -l "$packages"/*.tar.gz "$packages"/*.deb
