#!/bin/sh
# Puts headers, libraries, the pkg-config file and the CMake package under a prefix: install.sh PREFIX [FOLDER OF THE LIBRARIES]
# The libraries are those of `cargo build --release -p rhexis-c`, which puts them into target/release.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
prefix=${1:?"usage: install.sh PREFIX [FOLDER OF THE LIBRARIES]"}
built=${2:-"$here/../../target/release"}
mkdir -p "$prefix"
prefix=$(cd "$prefix" && pwd)

# Of the package, else of the workspace.
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' "$here/Cargo.toml" "$here/../../Cargo.toml" | head -n 1)
major=${version%%.*}
rest=${version#*.}
minor=${rest%%.*}

mkdir -p "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/rhexis"
cp "$here/include/rhexis.h" "$here/include/rhexis.hpp" "$prefix/include/"
found=no
for name in librhexis_c.so librhexis_c.dylib librhexis_c.a rhexis_c.lib rhexis_c.dll.lib; do
    if [ -f "$built/$name" ]; then
        cp "$built/$name" "$prefix/lib/"
        found=yes
    fi
done
if [ -f "$built/rhexis_c.dll" ]; then
    mkdir -p "$prefix/bin"
    cp "$built/rhexis_c.dll" "$prefix/bin/"
fi
if [ "$found" = no ]; then
    echo "$built has no library: run cargo build --release -p rhexis-c first, or name its folder" >&2
    exit 1
fi

fill() {
    sed -e "s|@VERSION@|$version|g" -e "s|@MAJOR@|$major|g" -e "s|@MINOR@|$minor|g" "$1" > "$2"
}
fill "$here/rhexis.pc.in" "$prefix/lib/pkgconfig/rhexis.pc"
fill "$here/cmake/rhexis-config.cmake.in" "$prefix/lib/cmake/rhexis/rhexis-config.cmake"
fill "$here/cmake/rhexis-config-version.cmake.in" "$prefix/lib/cmake/rhexis/rhexis-config-version.cmake"
