#!/usr/bin/env bash
# Installs the packages, builds everything and runs all tests. Arguments go to ctest, such as -R PlanarSegmentation.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
build=${FACETLOC_BUILD:-$root/build}

# Beside what facetloc needs: what the tests write ROS bags with, and a browser that looks at pages.
"$root/cmake/install_dependencies.sh" chromium python3-rosbag python3-sensor-msgs python3-nav-msgs python3-tf2-msgs
export CCACHE_SLOPPINESS=pch_defines,time_macros  # else it leaves alone what uses precompiled headers
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DFACETLOC_BUILD_TESTS=ON \
      -DFACETLOC_BUILD_BENCHMARKS=ON "-DCMAKE_CXX_COMPILER_LAUNCHER=$(command -v ccache)" ${FACETLOC_CMAKE_FLAGS:-}
cmake --build "$build"
ctest --test-dir "$build" --output-on-failure --parallel "$(nproc)" "$@"
