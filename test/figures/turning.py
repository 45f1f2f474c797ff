#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws a page of facetloc_render that turns, as an animated PNG: turning.py PAGE.html OUT.png

README's apps/pictures/turning.png is of a simulated home, by
    facetloc_simulate home -o home --seed 3 --width 320 --map-frames 500 --query-frames 300
    facetloc_map build home/map -o home.flmap && facetloc_localize home.flmap home/query --sequence -o results
    facetloc_render results --map home.flmap --sequence home/query -o answers.html && turning.py answers.html turning.png

Chromium draws all frames in one visit, offline."""
import base64
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy

WIDTH, HEIGHT, FRAMES, MILLISECONDS, COLOURS = 600, 400, 36, 110, 96

VISIT = """<style>header, footer, #scale { display: none !important; }</style><script>addEventListener('load', () => {
  const height = innerWidth * %d / %d, canvas = document.createElement('canvas'), context = canvas.getContext('2d'), out = document.createElement('div');
  canvas.width = %d; canvas.height = %d;
  dispatchEvent(new Event('resize'));
  for (let k = 0; k < %d; ++k) {
    facetloc.triangles();
    const scene = document.getElementById('scene'), scale = scene.width / innerWidth, top = (innerHeight - height) / 2;
    context.drawImage(scene, 0, scale * top, scene.width, scale * height, 0, 0, canvas.width, canvas.height);
    const rgb = context.getImageData(0, 0, canvas.width, canvas.height).data.filter((_, i) => i %% 4 < 3);
    let text = '';
    for (let i = 0; i < rgb.length; i += 3000) text += btoa(String.fromCharCode(...rgb.slice(i, i + 3000)));
    out.append('frame:' + text + ';');
    facetloc.turn(%f);
  }
  document.body.append(out);
});</script>"""


def frames_of(page):
    """All frames, FRAMES x HEIGHT x WIDTH x 3."""
    html = pathlib.Path(page).read_text()
    end = html.rindex("</body>")
    with tempfile.TemporaryDirectory() as folder:
        visited = pathlib.Path(folder) / "page.html"
        visited.write_text(html[:end] + VISIT % (HEIGHT, WIDTH, WIDTH, HEIGHT, FRAMES, 360 / FRAMES) + html[end:])
        dom = subprocess.run(
            ["chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
             "--force-device-scale-factor=2", "--virtual-time-budget=4000", "--blink-settings=preferredColorScheme=1",
             f"--user-data-dir={folder}", f"--window-size={WIDTH},{HEIGHT + 160}", "--dump-dom", f"file://{visited}"],
            check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout.decode()
    frames = [base64.b64decode(text) for text in re.findall(r"frame:([A-Za-z0-9+/=]+);", dom)]
    return numpy.frombuffer(b"".join(frames), numpy.uint8).reshape(FRAMES, HEIGHT, WIDTH, 3)


def indexed(frames):
    """A palette of the most frequent colours, and the nearest of them for each pixel."""
    bins = numpy.array([1024, 32, 1])
    all_bins = (frames >> 3) @ bins
    count = numpy.bincount(all_bins.ravel(), minlength=32768)
    chosen = numpy.sort(numpy.argsort(count, kind="stable")[-COLOURS:])
    centre = lambda cells: numpy.stack([cells >> 10, cells >> 5 & 31, cells & 31], 1) * 8 + 4
    difference = centre(numpy.arange(32768))[:, None] - centre(chosen)[None]
    nearest = (difference.astype(numpy.int32) ** 2).sum(2).argmin(1).astype(numpy.uint8)
    pixels = nearest[all_bins]
    palette = [[numpy.bincount(pixels.ravel(), frames[..., c].ravel(), COLOURS)[k] for c in range(3)] for k in range(COLOURS)]
    return numpy.round(palette / numpy.maximum(1, numpy.bincount(pixels.ravel(), minlength=COLOURS))[:, None]).astype(numpy.uint8), pixels


def write(path, palette, pixels):
    """An animated PNG, as PNG's third edition describes it; who knows none shows its first frame."""
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    size = struct.pack(">II", WIDTH, HEIGHT)
    out = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", size + bytes([8, 3, 0, 0, 0])) + chunk(b"acTL", struct.pack(">II", FRAMES, 0))
    out += chunk(b"PLTE", palette.tobytes())
    number = 0
    for k, frame in enumerate(pixels):
        out += chunk(b"fcTL", struct.pack(">I", number) + size + struct.pack(">IIHHBB", 0, 0, MILLISECONDS, 1000, 0, 0))
        data = zlib.compress(b"".join(b"\0" + row.tobytes() for row in frame), 9)
        number += 1
        if k == 0:
            out += chunk(b"IDAT", data)
        else:
            out += chunk(b"fdAT", struct.pack(">I", number) + data)
            number += 1
    pathlib.Path(path).write_bytes(out + chunk(b"IEND", b""))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} PAGE.html OUT.png")
    write(sys.argv[2], *indexed(frames_of(sys.argv[1])))
