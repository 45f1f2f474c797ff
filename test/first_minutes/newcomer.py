# SPDX-License-Identifier: BSD-3-Clause
"""Somebody who has just installed facetloc, with an empty folder and the installed documents: SCRIPT.py PREFIX DOCUMENTS

A script types what a section says and checks that the promised results are there, with readers of its own."""
import html.parser
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from documents import Document

HERE = pathlib.Path(__file__).resolve().parent


class Newcomer:
    """Works in a folder that goes away at the end."""

    def __init__(self):
        if len(sys.argv) != 3:
            sys.exit(f"usage: {sys.argv[0]} PREFIX DOCUMENTS")
        self.prefix, self.documents = (pathlib.Path(path).resolve() for path in sys.argv[1:])
        self.env = dict(os.environ, PATH=f"{self.prefix}/bin:{os.environ['PATH']}", PYTHONDONTWRITEBYTECODE="1")
        self.env.pop("DISPLAY", None)

    def __enter__(self):
        self.holder = tempfile.TemporaryDirectory(prefix="facetloc_first_minutes_")
        self.folder = pathlib.Path(self.holder.name)
        (self.folder / "apps").symlink_to(self.documents / "apps")
        return self

    def __exit__(self, *_):
        self.holder.cleanup()

    def document(self, name):
        return Document(self.documents / name)

    def type(self, command):
        """Runs a command as in a shell and returns what it prints; an exit code other than 0 ends the script."""
        print("$", command, flush=True)
        done = subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=self.folder, env=self.env, check=False,
                              text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        if done.returncode:
            sys.exit(f"exit code {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout + done.stderr

    def has(self, *names):
        for name in names:
            path = self.folder / name
            check(path.is_file() and path.stat().st_size > 0, f"{name} is there")

    def make_sample(self):
        """The sample recordings of the first steps."""
        simulate = [line for line in self.document("README.md").commands("First steps") if line.startswith("facetloc_simulate")]
        check(len(simulate) == 1, "the first steps make a sample")
        self.type(simulate[0])

    def poses(self, name):
        """Poses by stamp of a file in the TUM format: x y z and a unit quaternion x y z w."""
        found = {}
        for line in (self.folder / name).read_text(encoding="utf-8").splitlines():
            if line and not line.startswith("#"):
                stamp, *numbers = line.split()
                found[round(float(stamp), 3)] = [float(number) for number in numbers]
        return found

    def page(self, name):
        """The visible text of a page, which needs no other file and no network, and opens in a browser without an error."""
        text = (self.folder / name).read_text(encoding="utf-8")
        browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
        if browser:
            command = [browser, "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--dump-dom",
                       "--virtual-time-budget=4000", "--enable-logging=stderr", "--v=0", f"--user-data-dir={self.folder}/browser",
                       f"file://{self.folder / name}"]
            opened = subprocess.run(command, check=False, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            errors = [line for line in opened.stderr.splitlines() if "CONSOLE" in line]
            check(opened.returncode == 0 and len(opened.stdout) > 100 and not errors, f"{name} opens in a browser: {errors or 'no error'}")
        else:
            print("left out, without a browser: opening", name)
        reader = _Page()
        reader.feed(text)
        reader.close()
        check(not reader.outside, f"{name} needs nothing from outside: {reader.outside or 'nothing'}")
        return " ".join(reader.text.split())


class _Page(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.text, self.outside, self.hidden = "", [], 0

    def handle_starttag(self, tag, attributes):
        self.hidden += tag in ("script", "style")
        for key, value in attributes:
            if (key == "src" or key == "href" and tag == "link") and not (value or "").startswith("data:"):
                self.outside.append(value)

    def handle_endtag(self, tag):
        self.hidden -= tag in ("script", "style")

    def handle_data(self, data):
        self.text += "" if self.hidden else data + " "


def check(holds, what):
    print("ok  " if holds else "NOT ", what, flush=True)
    if not holds:
        sys.exit(1)


def difference(pose, other):
    """Metres and degrees between two poses."""
    metres = math.dist(pose[:3], other[:3])
    cosine = abs(sum(a * b for a, b in zip(pose[3:], other[3:])))
    return metres, math.degrees(2 * math.acos(min(1.0, cosine)))


def check_right(found, truth, least, metres=0.2, degrees=2.0):
    """At least this share of the true poses is found, and no found pose is wrong: by more than that, unless given as in the paper."""
    check(found.keys() <= truth.keys(), "each pose is of an image of the recording")
    check(len(found) >= least * len(truth), f"{len(found)} of {len(truth)} images have a sure pose")
    errors = {stamp: difference(found[stamp], truth[stamp]) for stamp in found}
    wrong = {stamp: error for stamp, error in errors.items() if error[0] > metres or error[1] > degrees}
    check(not wrong, f"no sure pose is wrong by more than {metres} m or {degrees} deg: {wrong or 'none'}")


def check_picture(path):
    """A PNG file of some size with more than one colour."""
    data = path.read_bytes()
    check(data[:8] == b"\x89PNG\r\n\x1a\n", f"{path.name} is a PNG picture")
    width, height = int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")
    check(width >= 100 and height >= 100 and len(data) > 2000, f"{path.name} shows something: {width}x{height}, {len(data)} bytes")
