#!/usr/bin/env bash
# A release (cmake/release.sh) on a bare Debian 12: what the packages bring along, that the Python package and the tools have the same
# answers, that the wheel has the answers of the packages, and the time from nothing to the first report.
#
#   test/packages.sh RELEASE [MAP.flmap RECORDING]     as root; takes minutes and 4 GB in the folder for temporary files
#
# Without MAP and RECORDING, a simulated room is mapped. FACETLOC_DEBIAN names a debootstrapped folder to use (it is copied).
# FACETLOC_FROM_SOURCE=1 builds from source there as well, for half an hour, and programs against the packages.
set -euo pipefail

release=$(realpath "$1")
repository=$(cd "$(dirname "$0")/.." && pwd)
map=${2:+$(realpath "$2")}
recording=${3:+$(realpath "$3")}
[ "$(id -u)" -eq 0 ] || { echo "packages: run as root, for chroot" >&2; exit 1; }
work=$(mktemp -d)
root=$work/debian
leave() {
  umount "$work"/*/proc 2>/dev/null || true
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
mkdir -p "$root/release"
cp -r "$release"/. "$root/release"
inside() { chroot "$root" env -u TMPDIR DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 "$@"; }
install_() { inside sh -c "apt-get install -y -qq --no-install-recommends $* >/tmp/apt.log 2>&1 || { tail /tmp/apt.log >&2; exit 1; }"; }
echo 'deb [trusted=yes] file:/release/apt ./' >"$root/etc/apt/sources.list.d/facetloc.list"
inside apt-get update -qq

# A second of it, and a third, as bare as the first.
for other in wheel ${FACETLOC_FROM_SOURCE:+source}; do cp -a "$root" "$work/$other"; done
for each in "$work"/*/; do mount -t proc proc "$each/proc" 2>/dev/null || true; done  # which a container may forbid

# WHAT COMMAND...: prints the seconds that a command takes.
timed() {
  local what=$1 begin=$EPOCHREALTIME
  shift
  "$@" || return
  awk -v b="$begin" -v e="$EPOCHREALTIME" -v what="$what" 'BEGIN { printf "%-40s %6.1f s\n", what, e - b }'
}
# HOW TOOLS: from the tools to the first report.
first_report() {
  timed "$1: sample recordings" inside "$2facetloc_simulate" room -o /walk --frames 60 --width 320 --quiet
  timed "$1: facetloc try" inside "$2facetloc" try /walk/map /walk/query -o /tried >"$root/try.log" 2>&1 || { cat "$root/try.log" >&2; exit 1; }
  tail -1 "$root/try.log"
  for page in report.html map.html; do [ -s "$root/tried/$page" ] || { echo "packages: $1: no $page" >&2; exit 1; }; done
}

# What newcomers read, and the scripts that type it.
documents() {
  mkdir "$root/documents"
  (cd "$repository" && cp -r --parents README.md apps registration/localization/README.md "$root/documents" && cp -r test/first_minutes "$root/documents")
}

# What a package would bring, without what it must not.
brings() {  # PACKAGE...
  inside sh -c "apt-get install --simulate --no-install-recommends $* | sed -n 's/^Inst \([^ ]*\).*/\1/p'"
}
tools=$(brings facetloc-tools)
echo "facetloc-tools brings $(wc -l <<<"$tools") packages"
if grep -E '^(lib)?(qt|vtk|openmpi|mpich|pcl-io|pcl-visualization)|^libx11-6$' <<<"$tools"; then
  echo "packages: facetloc-tools brings these along" >&2
  exit 1
fi
echo "facetloc-tools-gui brings $(brings "/release/apt/*.deb" | wc -l) packages, with all others of ours"

timed 'packages: download' install_ --download-only facetloc-tools-gui xvfb python3-facetloc
timed 'packages: apt install' install_ facetloc-tools-gui xvfb python3-facetloc
first_report packages ''
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
documents
inside python3 /documents/first_minutes/robot.py /usr /documents

# The wheel, where Python and NumPy are and nothing else.
root=$work/wheel
if python3 -m zipfile -l "$root"/release/*.whl | grep -iE 'vtk|qt|mpi|libX11|pcl_(io|visualization)'; then
  echo "packages: the wheel has these inside" >&2
  exit 1
fi
timed 'wheel: apt install python3 NumPy venv' install_ python3 python3-numpy python3-venv
timed 'wheel: pip install' inside sh -c 'python3 -m venv --system-site-packages /venv && /venv/bin/pip install --quiet --no-index /release/*.whl'
first_report wheel /venv/bin/
cmp "$work/debian/tried/details/results/hypotheses.csv" "$root/tried/details/results/hypotheses.csv"
cp -r "$work/debian/data" "$root"
inside /venv/bin/python /data/localize.py
documents
for newcomer in recording building python_user; do
  inside /venv/bin/python "/documents/first_minutes/$newcomer.py" /venv /documents
done

# From a clone.
if [ -n "${FACETLOC_FROM_SOURCE:-}" ]; then
  root=$work/source
  mkdir "$root/facetloc"
  git -C "$repository" archive HEAD | tar x -C "$root/facetloc"
  timed 'source: dependencies' inside sh -c 'cd /facetloc && cmake/install_dependencies.sh'
  timed 'source: build' inside sh -c 'cd /facetloc && cmake -G Ninja -B build -DFACETLOC_BUILD_TESTS=OFF >/dev/null && cmake --build build >/dev/null'
  first_report source /facetloc/build/apps/
  install_ libfacetloc-dev facetloc-tools-gui
  documents
  inside python3 /documents/first_minutes/pcl_pipeline.py /usr /documents
fi

echo "packages: all is well"
