#!/usr/bin/env bash
# The Debian packages on a bare Debian 12: what the tools bring along, and that the Python package and the tools localize alike.
#
#   test/packages.sh FOLDER_OF_PACKAGES [MAP.flmap RECORDING]     as root; takes minutes and 2 GB in the folder for temporary files
#
# Without MAP and RECORDING, a simulated room is mapped. FACETLOC_DEBIAN names a debootstrapped folder to use (it is copied).
set -euo pipefail

packages=$(realpath "$1")
map=${2:+$(realpath "$2")}
recording=${3:+$(realpath "$3")}
[ "$(id -u)" -eq 0 ] || { echo "packages: run as root, for chroot" >&2; exit 1; }
work=$(mktemp -d)
root=$work/debian
leave() {
  umount "$root/proc" 2>/dev/null || true
  rm -rf --one-file-system "$work"
}
trap leave EXIT

if [ -n "${FACETLOC_DEBIAN:-}" ]; then
  cp -a "$FACETLOC_DEBIAN" "$root"
else
  command -v debootstrap >/dev/null || { echo "packages: install debootstrap" >&2; exit 1; }
  # The mirror of this machine.
  mirror=$(grep -rhoE '(URIs: |^deb )https?://[^ ]+/debian/?( |$)' /etc/apt/sources.list /etc/apt/sources.list.d 2>/dev/null |
           grep -oE 'https?://[^ ]+' | head -1 || true)
  debootstrap --variant=minbase bookworm "$root" "${mirror:-http://deb.debian.org/debian}" >"$work/log" || { tail "$work/log" >&2; exit 1; }
fi
mount -t proc proc "$root/proc" 2>/dev/null || true  # which a container may forbid
mkdir -p "$root/packages"
cp "$packages"/*.deb "$root/packages"
inside() { chroot "$root" env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 "$@"; }
install_() { inside sh -c "apt-get install -y -qq --no-install-recommends $* >/tmp/apt.log 2>&1 || { tail /tmp/apt.log >&2; exit 1; }"; }
inside apt-get update -qq

# What a package would bring, without what it must not.
brings() {  # PACKAGE...
  inside sh -c "apt-get install --simulate --no-install-recommends $* | sed -n 's/^Inst \([^ ]*\).*/\1/p'"
}
tools=$(brings "/packages/libfacetloc0.3_*.deb" "/packages/facetloc-tools_*.deb")
echo "facetloc-tools brings $(wc -l <<<"$tools") packages"
if grep -E '^(lib)?(qt|vtk|openmpi|mpich|pcl-io|pcl-visualization)|^libx11-6$' <<<"$tools"; then
  echo "packages: facetloc-tools brings these along" >&2
  exit 1
fi
echo "facetloc-tools-gui brings $(brings "/packages/*.deb" | wc -l) packages, with all others of ours"

install_ "/packages/libfacetloc0.3_*.deb" "/packages/facetloc-tools_*.deb" "/packages/python3-facetloc_*.deb"
echo "installed: $(inside sh -c 'du -sxm / 2>/dev/null' | cut -f1) MB in all"
mkdir "$root/data"
if [ -z "$map" ]; then
  inside facetloc_simulate room -o /data/room --frames 30 --width 320 --quiet
  inside facetloc_map build /data/room/map -o /data/map.flmap --quiet
  mv "$root/data/room/query" "$root/data/recording"
else
  cp "$map" "$root/data/map.flmap"
  cp -rL "$recording" "$root/data/recording"
fi

inside facetloc_localize /data/map.flmap /data/recording -o /data/results --quiet
cat >"$root/data/localize.py" <<'PYTHON'
import csv
import facetloc
import numpy

localizer = facetloc.Localizer(facetloc.Map.open("/data/map.flmap"))
recording = facetloc.Recording.open("/data/recording")
with open("/data/results/hypotheses.csv") as file:
    best = {row["frame"]: row for row in csv.DictReader(file) if row["rank"] in ("", "0", "1")}
sure = 0
for frame in recording:
    answer, row = localizer.localize(frame.depth, recording.camera), best.pop(frame.name)
    assert answer.state == row["state"], (frame.name, answer.state, row["state"])
    sure += answer.sure
    if not answer.hypotheses:
        continue
    assert answer.hypotheses[0].model == row["model"], frame.name
    numpy.testing.assert_allclose(answer.probability, float(row["probability"]), rtol=1e-8, atol=1e-9)
    if answer.T_w_c is not None:
        numpy.testing.assert_allclose(answer.T_w_c[:3, 3], [float(row["w_t" + k]) for k in "xyz"], rtol=1e-7, atol=1e-8)
assert not best, "images that Python has not seen"
print(f"{len(recording)} images, {sure} sure: Python has the answers of facetloc_localize")
PYTHON
inside python3 /data/localize.py

echo "packages: all is well"
