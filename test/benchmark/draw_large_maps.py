#!/usr/bin/env python3
"""draw_large_maps.py CSV PICTURE: draws the recall of score_large_maps --csv by the number of best aligned local models."""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

with open(sys.argv[1], encoding="utf-8") as table:
    rows = list(csv.DictReader(table))
for models in dict.fromkeys(row["models"] for row in rows):
    points = [(int(row["shortlist"]), 100 * float(row["recall"])) for row in rows if row["models"] == models]
    pyplot.semilogx(*zip(*points), marker="o", label=f"{models} local models")
pyplot.ylim(60, 100)
pyplot.xlabel("best aligned local models")
pyplot.ylabel("recall [%]")
pyplot.title("Queries whose place is among the best aligned local models")
pyplot.grid()
pyplot.legend()
pyplot.savefig(sys.argv[2])
