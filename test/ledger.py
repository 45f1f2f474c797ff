#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Figures of results, and their comparison with the committed ones; for ledger.sh.

  ledger.py answers NAME FRAMES_CSV METRES DEGREES
                                           figures of each run that facetloc_evaluate has judged
  ledger.py states PREFIX RESULTS          figures of results without true poses
  ledger.py ratios FOLDER                  ratios of times: FOLDER has results kitchenN, officeN and strangeN
  ledger.py outside RUN LATER METRES       depth images of RUN that were taken farther than that from the middle third of LATER
  ledger.py parameters ROOT                number of parameters in the source
  ledger.py compare TSV FIGURES OUT [--rows PATTERN] [--quick] [--update]"""
import argparse
import collections
import csv
import fnmatch
import math
import pathlib
import statistics
import subprocess
import sys

import check_parameters

ELLIPSOID = 12.5916  # 95 % quantile of chi-square with 6 degrees of freedom
CONSISTENT = "1.5..9"  # median NEES of covariances that are right, ideally 5.35
SURE = 0.9           # probability from which an answer is sure, unless the map is calibrated
COLUMNS = ("figure", "value", "better", "tolerance", "quick", "reason")
# Direction and tolerance of a new row, by the first pattern that its name matches.
NEW_ROWS = (("cross.*.sure", "less", "0"), ("*.images", "same", "0"), ("*.first_sure", "less", "0"), ("*.sure_wrong", "less", "0"),
            ("*.sure_prob_mismatch", "less", "0"), ("*.in95", "more", "15%"), ("*.nees", CONSISTENT, "15%"), ("speed.*", "less", "15%"),
            ("pairs.*.wrong_converged", "less", "0"), ("map.*", "less", "15%"), ("house.cold_build*", "less", "15%"),
            ("house.*", "less", "0"), ("*", "more", "0"))


def show(figure, value):
    print(f"{figure}\t{value}")


def is_sure(row):
    return row["state"] == "sure"


def mismatches(answers, probability):
    """Answers whose state contradicts their probability."""
    return sum(is_sure(row) != (float(row[probability] or 0) >= SURE) for row in answers)


def answers(name, frames_csv, metres, degrees):
    runs = collections.defaultdict(list)
    with open(frames_csv, newline="") as file:
        for row in csv.DictReader(file):
            runs[row["run"]].append(row)

    def is_right(row):
        return (row["rank1_translation_mm"] != "" and float(row["rank1_translation_mm"]) <= 1000 * metres
                and float(row["rank1_orientation_deg"]) <= degrees)

    for run, frames in sorted(runs.items()):
        kind, _, gap = run.partition("_")
        prefix = f"{kind}.{name}" + ("_" + gap if gap else "")
        frames.sort(key=lambda row: float(row["stamp"]))
        sure = [row for row in frames if is_sure(row)]
        right = [row for row in sure if is_right(row)]
        nees = [float(row["nees"]) for row in right if row["nees"]]
        show(prefix + ".images", len(frames))
        show(prefix + ".rank1", sum(map(is_right, frames)))
        show(prefix + ".sure", len(sure))
        show(prefix + ".sure_right", len(right))
        show(prefix + ".sure_wrong", len(sure) - len(right))
        show(prefix + ".sure_prob_mismatch", mismatches(frames, "rank1_probability"))
        if kind == "drive":  # one more than there are images, if none is sure
            show(prefix + ".first_sure", next((i for i, row in enumerate(frames, 1) if is_sure(row)), len(frames) + 1))
        show(prefix + ".in95", f"{100 * sum(e <= ELLIPSOID for e in nees) / len(nees):.1f}" if nees else "-")
        show(prefix + ".nees", f"{statistics.median(nees):.2f}" if nees else "-")


def outside(run, later, metres):
    def positions(folder):
        with open(pathlib.Path(folder) / "groundtruth.txt") as file:
            return [tuple(map(float, line.split()[1:4])) for line in file if line.strip() and not line.startswith("#")]

    middle = positions(later)
    middle = middle[len(middle) // 3:2 * len(middle) // 3]
    images = sorted((path.name for path in (pathlib.Path(run) / "depth").iterdir()), key=lambda name: float(pathlib.Path(name).stem))
    for image, position in zip(images, positions(run), strict=True):
        if min(math.dist(position, other) for other in middle) > float(metres):
            print(image)


def states(prefix, results):
    with open(pathlib.Path(results) / "hypotheses.csv", newline="") as file:
        frames = [row for row in csv.DictReader(file) if int(row["rank"]) <= 1]
    show(prefix + ".images", len(frames))
    show(prefix + ".sure", sum(map(is_sure, frames)))
    show(prefix + ".sure_prob_mismatch", mismatches(frames, "probability"))


def shortest_times(folder, name, columns):
    """Mean over the images of the shortest time in all rounds [ms]."""
    shortest = collections.defaultdict(lambda: float("inf"))
    for results in pathlib.Path(folder).glob(name + "[0-9]"):
        with open(results / "timing.csv", newline="") as file:
            for row in csv.DictReader(file):
                shortest[row["frame"]] = min(shortest[row["frame"]], sum(float(row[c]) for c in columns))
    return statistics.mean(shortest.values())


def ratios(folder):
    def query(name):
        return shortest_times(folder, name, ["localize_ms"])

    show("speed.not_in_map_to_query", f"{query('strange') / query('office'):.2f}")
    show("speed.query_to_segmentation",
         f"{query('kitchen') / shortest_times(folder, 'kitchen', ['segment_ms', 'features_ms']):.2f}")


def parameters(root):
    print(len(check_parameters.parameters(pathlib.Path(root))))


class Row:
    def __init__(self, figure, value, better, tolerance, quick, reason):
        self.figure, self.value, self.better, self.tolerance = figure, value, better, tolerance
        self.quick, self.reason = quick, reason

    @classmethod
    def new(cls, figure, value, quick):
        better, tolerance = next(line[1:] for line in NEW_ROWS if fnmatch.fnmatchcase(figure, line[0]))
        return cls(figure, value, better, tolerance, quick, "first measured")

    def line(self):
        return "\t".join((self.figure, self.value, self.better, self.tolerance, self.quick, self.reason))

    def verdict(self, value):
        """The verdict on another value; '-' marks a figure without answers to judge."""
        if "-" in (self.value, value) or float(self.value) == float(value):
            return "same"
        was, now = float(self.value), float(value)
        if ".." in self.better:
            return self.verdict_within(was, now)
        allowed = abs(was) * float(self.tolerance[:-1]) / 100 if self.tolerance.endswith("%") else float(self.tolerance)
        if abs(now - was) <= allowed:
            return "same"
        return "better" if self.better == ("more" if now > was else "less") else "WORSE"

    def verdict_within(self, was, now):
        """Inside the interval all values are equal; outside, the farther by ratio the worse."""
        low, high = map(float, self.better.split(".."))

        def off(x):
            return max(math.log(low / x) if x > 0 else math.inf, math.log(x / high) if x > 0 else 0, 0)

        farther = off(now) - off(was)
        if abs(farther) <= math.log1p(float(self.tolerance[:-1]) / 100):
            return "same"
        return "WORSE" if farther > 0 else "better"


def rows_of(text):
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    if not lines:
        return {}
    if tuple(lines[0].split("\t")) != COLUMNS:
        sys.exit("ledger.py: the columns of ledger.tsv are " + " ".join(COLUMNS))
    table = {}
    for line in lines[1:]:
        cells = line.split("\t")
        if len(cells) != len(COLUMNS) or not cells[-1] or cells[2] not in ("more", "less", "same", CONSISTENT):
            sys.exit(f"ledger.py: a line needs {len(COLUMNS)} cells, a direction (more, less, same, {CONSISTENT}) and a reason: {line}")
        table[cells[0]] = Row(*cells)
    return table


def write(path, rows):
    lines = ["\t".join(COLUMNS)] + [rows[figure].line() for figure in sorted(rows)]
    pathlib.Path(path).write_text("\n".join(lines) + "\n")


def earlier(tsv):
    """The committed rows before the latest change of the file; empty if there are none."""
    def git(*arguments):
        done = subprocess.run(["git", *arguments], cwd=tsv.parent, text=True, capture_output=True)
        return done.stdout.strip() if done.returncode == 0 else ""

    changed = git("status", "--porcelain", "--", tsv.name)
    commit = "HEAD" if changed else git("log", "-1", "--format=%H", "--", tsv.name) + "^"
    return rows_of(git("show", f"{commit}:./{tsv.name}"))


def without_reason(tsv, committed):
    """Rows whose line got worse by its latest change and kept its reason."""
    return [f"{figure}: {was.value} -> {committed[figure].value}, with the reason as before"
            for figure, was in earlier(tsv).items()
            if figure in committed and was.verdict(committed[figure].value) == "WORSE" and was.reason == committed[figure].reason]


def measured_rows(folder):
    return {figure: Row.new(figure, value, "yes" if path.parent.name == "quick" else "no")
            for path in sorted(pathlib.Path(folder).glob("*/*.tsv"))
            for figure, value in (line.split("\t") for line in path.read_text().splitlines())}


def compare(options):
    tsv = pathlib.Path(options.tsv).resolve()
    committed = rows_of(tsv.read_text()) if tsv.exists() else {}
    measured = {f: row for f, row in measured_rows(options.figures).items() if fnmatch.fnmatchcase(f, options.rows)}
    verdicts = collections.Counter()
    print(f"{'figure':<48} {'committed':>10} {'measured':>10}")
    for figure, row in sorted(measured.items()):
        known = committed.get(figure)
        verdict = known.verdict(row.value) if known else "new"
        verdicts[verdict] += 1
        print(f"{figure:<48} {known.value if known else '':>10} {row.value:>10}  {verdict}")
        if known:
            row.better, row.tolerance, row.quick, row.reason = known.better, known.tolerance, known.quick, known.reason
    write(options.out, measured)
    print(", ".join(f"{count} {verdict}" for verdict, count in sorted(verdicts.items())))
    skipped = [row for f, row in committed.items() if f not in measured and fnmatch.fnmatchcase(f, options.rows)]
    if skipped:
        later = sum(options.quick and row.quick == "no" for row in skipped)
        print(f"skipped: {later} rows of the full run, {len(skipped) - later} that nothing here measures")
    if options.update:
        write(tsv, {**committed, **measured})
        committed = rows_of(tsv.read_text())
        print(f"updated: {tsv.name}; each row that got worse needs a new reason")
    unexplained = without_reason(tsv, committed)
    print(*unexplained, sep="\n", end="\n" if unexplained else "")
    return 1 if unexplained or (verdicts["WORSE"] and not options.update) else 0


def main():
    commands = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    command = commands.add_subparsers(dest="command", required=True)
    for name, arguments in (("answers", ["name", "frames_csv"]), ("states", ["prefix", "results"]), ("ratios", ["folder"]),
                            ("outside", ["run", "later", "metres"]), ("parameters", ["root"]),
                            ("compare", ["tsv", "figures", "out"])):
        parser = command.add_parser(name)
        for argument in arguments:
            parser.add_argument(argument)
        if name == "answers":
            parser.add_argument("metres", type=float)
            parser.add_argument("degrees", type=float)
        if name == "compare":
            parser.add_argument("--rows", default="*")
            parser.add_argument("--quick", action="store_true")
            parser.add_argument("--update", action="store_true")
    options = commands.parse_args()
    if options.command == "compare":
        return compare(options)
    call = {k: v for k, v in vars(options).items() if k != "command"}
    globals()[options.command](**call)
    return 0


if __name__ == "__main__":
    sys.exit(main())
