#!/usr/bin/env bash
# All that a release consists of, on Debian 12: cmake/release.sh [OUT]
#
# OUT/apt has the Debian packages and is a source of apt, OUT/facetloc-*.whl is the wheel, and OUT/SHA256SUMS lists all of them. OUT is
# out/release unless given. FACETLOC_BUILD names a finished build to take the packages from; otherwise build-release is made.
set -euo pipefail

cd "$(dirname "$0")/.."
out=${1:-out/release} build=${FACETLOC_BUILD:-build-release}
cmake/install_dependencies.sh dpkg-dev python3-pip python3-setuptools python3-wheel
mkdir -p "$out/apt"
out=$(realpath "$out")
rm -f "$out"/*.whl "$out"/apt/*
export CMAKE_GENERATOR=Ninja CMAKE_CXX_COMPILER_LAUNCHER=ccache

if [ -z "${FACETLOC_BUILD:-}" ]; then
  cmake -S . -B "$build" -DFACETLOC_BUILD_TESTS=OFF
  cmake --build "$build"
fi
(cd "$build" && rm -f ./*.deb && cpack --config CPackConfig.cmake >/dev/null && mv ./*.deb "$out/apt")
(cd "$out/apt" && dpkg-scanpackages --multiversion . >Packages 2>/dev/null)
# The distribution's Python and setuptools, and no network.
/usr/bin/python3 -m pip wheel --quiet --no-build-isolation --no-deps --wheel-dir "$out" .
(cd "$out" && sha256sum ./*.whl apt/*.deb >SHA256SUMS)

ls -l "$out" "$out/apt"
echo "release: in $out; for apt: echo 'deb [trusted=yes] file:$out/apt ./' >/etc/apt/sources.list.d/facetloc.list"
