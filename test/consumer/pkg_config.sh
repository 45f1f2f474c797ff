#!/bin/sh
# Compiles an example against the installed libraries by pkg-config alone: pkg_config.sh PREFIX LIBDIR EXAMPLE.cpp
set -eu
export PKG_CONFIG_PATH="$1/$2/pkgconfig"
program=$(mktemp)
trap 'rm -f "$program"' EXIT
# shellcheck disable=SC2046
c++ -std=c++17 "$3" $(pkg-config --cflags --libs facetloc) -o "$program"
LD_LIBRARY_PATH="$1/$2" "$program" 2>&1 | grep usage:
