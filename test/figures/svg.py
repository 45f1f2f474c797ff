# SPDX-License-Identifier: BSD-3-Clause
"""A small writer of SVG files: the same numbers, the same bytes."""
import base64
import html
import struct
import zlib

# Colours that print, and that the colour-blind tell apart (Okabe, Ito, 2002).
BLACK, GREY, PALE = "#222222", "#777777", "#cccccc"
BLUE, ORANGE, GREEN, RED, SKY, YELLOW, PINK = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#56b4e9", "#f0e442", "#cc79a7"
SURFACES = [BLUE, ORANGE, GREEN, PINK, SKY, RED, YELLOW]


def number(value):
    """With one decimal, where it is not 0."""
    text = f"{value:.1f}".removesuffix(".0")
    return "0" if text == "-0" else text


def points(path):
    return " ".join(f"{number(x)},{number(y)}" for x, y in path)


class Figure:
    """A white page with shapes on it, in pixels; y goes down."""

    def __init__(self, width, height):
        self.size = width, height
        self.parts = []
        self.rectangle(0, 0, width, height, fill="#ffffff")

    def add(self, tag, **attributes):
        inner = attributes.pop("inner", None)
        text = "".join(f' {key.replace("_", "-")}="{number(value) if isinstance(value, (int, float)) else html.escape(value)}"'
                       for key, value in attributes.items() if value is not None)
        self.parts.append(f"<{tag}{text}/>" if inner is None else f"<{tag}{text}>{html.escape(inner)}</{tag}>")

    def rectangle(self, x, y, width, height, fill="none", stroke=None, stroke_width=None, rx=None, dash=None, crisp=False):
        self.add("rect", x=x, y=y, width=width, height=height, fill=fill, stroke=stroke, stroke_width=stroke_width, rx=rx,
                 stroke_dasharray=dash, shape_rendering="crispEdges" if crisp else None)

    def line(self, path, stroke=BLACK, width=1.0, dash=None, opacity=None):
        self.add("polyline", points=points(path), fill="none", stroke=stroke, stroke_width=width, stroke_dasharray=dash,
                 stroke_opacity=opacity and f"{opacity:.2f}", stroke_linejoin="round")

    def polygon(self, path, fill, stroke=None, width=None, opacity=None):
        self.add("polygon", points=points(path), fill=fill, stroke=stroke, stroke_width=width,
                 fill_opacity=opacity and f"{opacity:.2f}")

    def squares(self, boxes, fill):
        """Rectangles with thin white borders, as one shape."""
        path = "".join(f"M{number(x0)} {number(y0)}H{number(x1)}V{number(y1)}H{number(x0)}z" for x0, y0, x1, y1 in boxes)
        self.add("path", d=path, fill=fill, stroke="#ffffff", stroke_width=0.4)

    def circle(self, x, y, radius, fill=BLACK, stroke=None, width=None):
        self.add("circle", cx=x, cy=y, r=radius, fill=fill, stroke=stroke, stroke_width=width)

    def arrow(self, begin, end, stroke=BLACK, width=1.5, head=6.0):
        (x0, y0), (x1, y1) = begin, end
        length = max(1e-9, ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5)
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        foot = x1 - head * ux, y1 - head * uy
        self.line([begin, foot], stroke, width)
        self.polygon([end, (foot[0] - head / 2 * uy, foot[1] + head / 2 * ux), (foot[0] + head / 2 * uy, foot[1] - head / 2 * ux)], stroke)

    def text(self, x, y, text, size=12, anchor="start", fill=BLACK, bold=False, halo=False, turn=None):
        self.add("text", x=x, y=y, font_size=size, text_anchor=anchor if anchor != "start" else None, fill=fill,
                 font_weight="bold" if bold else None, stroke="#ffffff" if halo else None, stroke_width=3 if halo else None,
                 paint_order="stroke" if halo else None,
                 transform=turn and f"rotate({turn} {number(x)} {number(y)})", inner=text)

    def depth(self, rows, x, y, width, height):
        """A depth image [cm] in 16 greys, near is bright; not measured is black."""
        known = sorted(value for row in rows for value in row if value)
        near, far = known[len(known) // 50], known[-len(known) // 50]
        grey = lambda value: 15 - round(12 * min(1, max(0, (value - near) / (far - near)))) if value else 0
        self.raster([[grey(value) for value in row] for row in rows], [bytes([17 * k] * 3) for k in range(16)], x, y, width, height)

    def raster(self, rows, palette, x, y, width, height):
        """An image of up to 16 colours, given by their bytes."""
        lines = b"".join(b"\0" + bytes(a << 4 | b for a, b in zip(row[::2], row[1::2])) for row in rows)

        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", len(rows[0]), len(rows), 4, 3, 0, 0, 0))
        png += chunk(b"PLTE", b"".join(palette))
        png += chunk(b"IDAT", zlib.compress(lines, 0)) + chunk(b"IEND", b"")  # stored: the same by any zlib
        self.add("image", x=x, y=y, width=width, height=height, preserveAspectRatio="none",
                 href="data:image/png;base64," + base64.b64encode(png).decode())

    def write(self, path, title):
        width, height = self.size
        head = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
                f'font-family="DejaVu Sans, Arial, sans-serif" role="img">\n<title>{html.escape(title)}</title>\n')
        path.write_text(head + "\n".join(self.parts) + "\n</svg>\n", encoding="utf-8")


class Plot:
    """A frame with axes in a figure: points in units of the axes, ticks and titles."""

    def __init__(self, figure, box, x_range, y_range):
        self.figure, self.box, self.x_range, self.y_range = figure, box, x_range, y_range

    def at(self, x, y):
        (left, top, width, height), (x0, x1), (y0, y1) = self.box, self.x_range, self.y_range
        return left + width * (x - x0) / (x1 - x0), top + height * (y1 - y) / (y1 - y0)

    def path(self, pairs):
        """Clipped below and above, where a curve leaves the frame."""
        low, high = self.y_range
        return [self.at(x, min(high, max(low, y))) for x, y in pairs]

    def axes(self, x_title, y_title, x_ticks, y_ticks):
        figure, (left, top, width, height) = self.figure, self.box
        for value in x_ticks:
            x, _ = self.at(value, 0)
            figure.line([(x, top + height), (x, top + height + 4)])
            figure.text(x, top + height + 17, f"{value:g}", 11, "middle")
        for value in y_ticks:
            _, y = self.at(0, value)
            figure.line([(left, y), (left + width, y)], "#eeeeee")
            figure.text(left - 6, y + 4, f"{value:g}", 11, "end")
        figure.rectangle(left, top, width, height, stroke=BLACK, stroke_width=1)
        figure.text(left + width / 2, top + height + 34, x_title, 12, "middle")
        figure.text(left, top - 8, y_title, 12)
