# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of maps and answers: plots of matplotlib, and the page of facetloc_render."""
from __future__ import annotations

import html
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import webbrowser
from typing import TYPE_CHECKING, Any, Iterable, Optional, Union

import numpy as np

from ._checks import checked

if TYPE_CHECKING:
    from . import Answer, Map

UPRIGHT = np.sin(np.radians(20))  # largest vertical part of an upright segment's normal
CHI2_95 = 5.991  # 0.95 quantile of chi square of 2 degrees of freedom


def draw(map: Map, answers: Iterable[Answer] = (), ax: Any = None) -> Any:
    """Draws a map from above with matplotlib: upright segments as lines, local models as dots. Of each answer the best place: sure ones
    green with the 95 % ellipse of their position, doubtful ones yellow. The axes are those of the world [m].

    ax: matplotlib axes, new ones unless given. Returns them. Only the part of the map that is drawn first is drawn: parts have no common
    frame."""
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Ellipse

    from . import Answer, Map
    checked(map, "map", Map)
    answers = [answers] if isinstance(answers, Answer) else [checked(a, f"answers[{i}]", Answer) for i, a in enumerate(answers)]
    if ax is None:
        ax = plt.figure().add_subplot()
    models = [(i, model) for i, model in enumerate(map.models) if model.T_w_m is not None]
    part = models[0][1].part if models else ""
    walls = []
    for i, model in models:
        for segment in map.segments(i) if model.part == part else ():
            R, t = model.T_w_m[:3, :3], model.T_w_m[:3, 3]
            normal = R @ segment.normal
            if abs(normal[2]) < UPRIGHT:
                corners = (segment.hull @ R.T + t)[:, :2]
                along = corners @ [-normal[1], normal[0]]
                walls.append(corners[[np.argmin(along), np.argmax(along)]])
    ax.add_collection(LineCollection(walls, colors="0.3", linewidths=1, alpha=0.5, label="upright segments"))
    ax.plot(*np.array([m.T_w_m[:2, 3] for _, m in models if m.part == part]).reshape(-1, 2).T, ".", color="0.6", label="local models")
    for state, colour in (("doubtful", "tab:olive"), ("sure", "tab:green")):
        found = [a for a in answers if a.state == state and a.T_w_c is not None and a.hypotheses[0].part == part]
        if not found:
            continue
        ax.quiver(*np.array([[*a.T_w_c[:2, 3], *a.T_w_c[:2, 2]] for a in found]).T, color=colour, angles="xy", width=0.004,
                  alpha=1 if state == "sure" else 0.4, label=f"{state} ({len(found)})")
        for a in found if state == "sure" else ():
            size, axes = np.linalg.eigh(a.covariance[3:5, 3:5])
            width, height = 2 * np.sqrt(CHI2_95 * np.maximum(size, 0))
            ax.add_patch(Ellipse(a.T_w_c[:2, 3], width, height, angle=np.degrees(np.arctan2(axes[1, 0], axes[0, 0])), fill=False, color=colour))
    ax.autoscale_view()
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.legend(fontsize="small", framealpha=0.6)
    return ax


class Page:
    """A page of a map. In a notebook it shows itself."""

    def __init__(self, path: pathlib.Path):
        self.path = path  #: of the file, which needs no others

    def __repr__(self) -> str:
        return f"Page({str(self.path)!r})"

    def _repr_html_(self) -> str:
        page = html.escape(self.path.read_text(encoding="utf-8"))
        return f'<iframe srcdoc="{page}" width="100%" height="600" style="border: 0"></iframe>'


def show(map: Map, path: Optional[Union[str, os.PathLike]] = None) -> Page:
    """Shows a map as a page to turn, zoom and click: in a notebook below the cell, else in a browser. path: where the page is written,
    a temporary folder unless given. Needs the program facetloc_render, and raises FileNotFoundError without it."""
    from . import Map
    checked(map, "map", Map)
    program = shutil.which("facetloc_render")
    if program is None:
        raise FileNotFoundError("facetloc_render, which makes the page, is not on the PATH: install facetloc-tools-gui")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="facetloc-"))
    page = Page(pathlib.Path(path) if path is not None else folder / "map.html")
    if map.path is None:
        map._map.save(str(folder / "map.flmap"))  # as it is: path stays None
    try:
        subprocess.run([program, str(map.path or folder / "map.flmap"), "-o", str(page.path), "--quiet"], check=True, capture_output=True, text=True)
    except subprocess.CalledProcessError as error:
        raise RuntimeError(f"facetloc_render: {error.stderr.strip()}") from None
    finally:
        (folder / "map.flmap").unlink(missing_ok=True)
        if path is not None:
            folder.rmdir()
    if "ipykernel" not in sys.modules:
        webbrowser.open(page.path.resolve().as_uri())
    return page
