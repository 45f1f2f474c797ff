#!/usr/bin/env bash
# The core libraries on 64-bit ARM: cross-compiles them and their tests, runs the tests under qemu, and compares the answers of
# localization in a simulated office with those of this machine's processor.
#
#   test/aarch64.sh [-i] [FOLDER]     -i installs a missing compiler and emulator; FOLDER is build-aarch64 if not given
#
# Nothing is tested without compiler and emulator. The answers of this machine come from its own build (test/run.sh), in $FACETLOC_BUILD
# or build. Debian's libraries for ARM are unpacked in FOLDER, not installed: 160 MB to download, 1 GB in all.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
[ "${1:-}" != -i ] || { "$root/cmake/install_dependencies.sh" g++-aarch64-linux-gnu qemu-user-static; shift; }
if ! command -v aarch64-linux-gnu-g++ >/dev/null || ! command -v qemu-aarch64-static >/dev/null; then
  echo "aarch64: left out, for want of g++-aarch64-linux-gnu and qemu-user-static (-i installs them)"
  exit 0
fi
native=${FACETLOC_BUILD:-$root/build}
[ -f "$native/build.ninja" ] || { echo "aarch64: build for this machine first (test/run.sh)" >&2; exit 1; }
folder=${1:-$root/build-aarch64}
mkdir -p "$folder"
folder=$(realpath "$folder")
sysroot=$folder/sysroot build=$folder/build  # apart, as CMake wants it

# These come with all that they depend on. PCL's io brings VTK's libraries, which no test calls.
packages=(libc6-dev libpcl-features1.13 libpcl-io1.13 libpcl-registration1.13 libflann1.9 libeigen3-dev libboost-dev
          libboost-date-time-dev libboost-filesystem-dev libboost-iostreams-dev libboost-serialization-dev libboost-system-dev
          libbz2-dev libceres-dev libdeflate-dev libembree-dev libfmt-dev libgmock-dev libgtest-dev libjsoncpp-dev liblz4-dev
          libopenni2-dev libpng-dev libsqlite3-dev libtiff-dev libusb-1.0-0-dev libyaml-cpp-dev libzstd-dev)
# Headers alone: what these depend on would be the headers of VTK, Qt and MPI.
headers=(libflann-dev libpcl-dev)
if [ "$(cat "$sysroot/packages" 2>/dev/null)" != "${packages[*]} ${headers[*]}" ]; then
  # An apt of its own, for a machine with nothing installed.
  apt=$folder/apt
  rm -rf "$apt" "$sysroot"
  mkdir -p "$sysroot" "$apt"/{state/lists,cache/archives}/partial
  : >"$apt/status"
  cat >"$apt/apt.conf" <<APT
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
APT::Install-Recommends "false";
APT::Sandbox::User "root";
Dir::State "$apt/state";
Dir::State::status "$apt/status";
Dir::Cache "$apt/cache";
APT
  export APT_CONFIG=$apt/apt.conf
  apt-get update -qq
  apt-get install -y -qq --download-only "${packages[@]}" >/dev/null
  (cd "$apt/cache/archives" && apt-get download -qq "${headers[@]}")
  for package in "$apt"/cache/archives/*.deb; do dpkg-deb --extract "$package" "$sysroot"; done
  rm -rf "$apt"
  libraries=$sysroot/usr/lib/aarch64-linux-gnu
  # Links to the root, and the links that an installation would add.
  find "$sysroot" -lname '/*' | while read -r link; do ln -snf "$sysroot$(readlink "$link")" "$link"; done
  (cd "$libraries" && ln -s atlas/lib{blas,lapack}.so* .)
  sed -i 's|;/usr/lib/[^;"]*||g' "$libraries/cmake/Ceres/CeresTargets.cmake"  # its own needs, by their paths in the root
  echo "${packages[*]} ${headers[*]}" >"$sysroot/packages"
fi

export CCACHE_SLOPPINESS=pch_defines,time_macros
modules=(features segmentation registration localization)
cmake -S "$root" -B "$build" -G Ninja --toolchain "$root/cmake/aarch64.cmake" "-DCMAKE_SYSROOT=$sysroot" -DCMAKE_BUILD_TYPE=Release \
      -DFACETLOC_BUILD_APPS=OFF -DFACETLOC_WERROR=ON -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON \
      "-DCMAKE_CXX_COMPILER_LAUNCHER=$(command -v ccache)" >/dev/null
cmake --build "$build" --target "${modules[@]/#/test_}"
cmake --build "$native" --target test_localization
# Left out: long drives, many images and a fine rendering, a minute or more for most of these tests, as qemu takes 25 times as long.
slow='^(FilmOf|KnownGravity|LensCorrection.Gives|MapInParts|PlaceIndexOfRooms|RealImages|Sequence|SureCalibration)'
ctest --test-dir "$build" --output-on-failure --parallel "$(nproc)" --label-regex "^($(IFS='|'; echo "${modules[*]}"))\$" --exclude-regex "$slow"

comparison=(--gtest_filter=MapInParts.AnswersAreRecorded* --gtest_brief=1)
"$native/test/test_localization" "${comparison[@]}" "--gtest_output=json:$folder/native.json"
qemu-aarch64-static -L "$sysroot" "$build/test/test_localization" "${comparison[@]}" "--gtest_output=json:$folder/aarch64.json"
python3 - "$folder/native.json" "$folder/aarch64.json" <<'PYTHON'
import json
import math
import sys

# Metres, radians, nats.
LIMITS = {"translation": 1e-4, "rotation": 1e-4, "log odds": 0.01}


def answers(path):
    with open(path) as file:
        test = json.load(file)["testsuites"][0]["testsuite"][0]
    return {name: value.split() for name, value in test.items() if name.startswith(("single", "drive"))}


native, other = answers(sys.argv[1]), answers(sys.argv[2])
assert native.keys() == other.keys() and len(native) > 50, "not the same images"
largest, wrong = dict.fromkeys(LIMITS, 0.0), []
for name in native:
    a, b = native[name], other[name]
    if a[:2] != b[:2]:  # state and local model
        wrong.append(f"{name}: {' '.join(a)}, but {' '.join(b)}")
    elif len(a) > 1:
        a, b = [float(x) for x in a[2:]], [float(x) for x in b[2:]]
        sign = math.copysign(1, sum(x * y for x, y in zip(a[4:], b[4:])))  # a quaternion and its negative are one rotation
        difference = {"translation": math.dist(a[1:4], b[1:4]), "rotation": 2 * math.dist(a[4:], [sign * x for x in b[4:]]),
                      "log odds": abs(a[0] - b[0])}
        largest = {key: max(largest[key], difference[key]) for key in LIMITS}
        wrong += [f"{name}: {key} differs by {difference[key]:.2g}" for key in LIMITS if not difference[key] <= LIMITS[key]]
print("aarch64: {} answers, which differ at most by {}".format(len(native), ", ".join(f"{x:.2g} in {key}" for key, x in largest.items())))
sys.exit("\n".join(wrong) or 0)
PYTHON
