#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Counts the parameters in the source: check_parameters.py [FOLDER_OF_TOOLS]

A parameter is a field that a describe() visits with a range (features/params.h); the fitted constants of calibration.h are none. A
describe() has one form and contains visits alone, so that no field escapes the count. Fails if there are more than 120, if the text
in CONTRIBUTING.md has other numbers, or if the tools, where they are given, have no option for a parameter."""
import ast
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MODULES = ("features", "segmentation", "registration", "io", "apps")
CALIBRATION = "registration/include/facetloc/registration/calibration.h"
MAXIMUM = 120
OTHER_HELP = {"FloorPlanParams"}  # --wall-height and --ceiling have their own; the rest is for programs in C++
SIGNATURE = r"static void describe\w*\(Self& p, Visitor&& visit\) \{"
STRING = r'"(?:[^"\\]|\\.)*"'


class Parameter:
    def __init__(self, struct, name, help_text, is_for_users):
        self.struct, self.name, self.help, self.is_for_users = struct, name, help_text, is_for_users

    def __str__(self):
        return f"{self.struct}::{self.name}"


def closing(text, begin):
    """Position after the bracket that closes the one before begin."""
    depth, at = 1, begin
    while depth:
        depth += {"(": 1, "{": 1, ")": -1, "}": -1}.get(text[at], 0)
        at += 1
    return at


def arguments(call):
    parts, depth = [""], 0
    for character in call:
        depth += {"(": 1, "{": 1, ")": -1, "}": -1}.get(character, 0)
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts]


def literal(expression, strings):
    if not re.fullmatch(r"(\s*\$\d+)+", expression):
        raise ValueError(f"the name and the help of a field are plain strings, not {expression}")
    return "".join(ast.literal_eval(strings[int(n)]) for n in re.findall(r"\d+", expression))


def parameters_in(struct, body, strings):
    """The parameters of a describe(); strings: what its placeholders $0, $1 stand for."""
    found, rest, at = [], "", 0
    for call in re.finditer(r"\bvisit\(", body):
        end = closing(body, call.end())
        rest += body[at:call.start()]
        at = end
        given = arguments(body[call.end():end - 1])
        if len(given) not in (2, 5, 6) or given[5:] not in ([], ["kForUsers"]):
            raise ValueError(f"visit({', '.join(given)}) is neither a group nor a field with its range and its help")
        if len(given) > 2:
            found.append(Parameter(struct, literal(given[0], strings), literal(given[4], strings), len(given) == 6))
    rest = re.sub(r"\b(\w+::)?describe\w*\(p, visit\);", "", rest + body[at:])
    if rest.strip(" ;\n"):
        raise ValueError(f"a describe() contains more than visits: {' '.join(rest.split())}")
    return found


def parameters_of(path):
    text, strings = re.sub(r"^ \*.*$|//[^\n\"]*$", "", path.read_text("utf-8"), flags=re.M), []

    def placeholder(match):
        strings.append(match[0])
        return f"${len(strings) - 1}"

    text = re.sub(STRING, placeholder, text)
    bodies = list(re.finditer(SIGNATURE, text))
    if len(bodies) != len(re.findall(r"\bstatic[^;{}()]*\bdescribe\w*\(", text)):
        raise ValueError("a describe() is not declared as: static void describe(Self& p, Visitor&& visit) {")
    found = []
    for body in bodies:
        struct = re.findall(r"\b(?:struct|class) (\w+)[^;{}()]*\{", text[:body.start()])[-1]
        found += parameters_in(struct, text[body.end():closing(text, body.end()) - 1], strings)
    return found


def parameters(root=ROOT):
    found = []
    for module in MODULES:
        for path in sorted((root / module).rglob("*")):
            if path.suffix in (".h", ".hpp", ".cpp") and path != root / CALIBRATION:
                try:
                    found += parameters_of(path)
                except ValueError as error:
                    sys.exit(f"{path.relative_to(root)}: {error}")
    return found


def help_of_tools(folder):
    """The texts that all tools print for --help-all, without line ends."""
    def output(*command):
        return subprocess.run(command, text=True, capture_output=True).stdout

    texts = []
    for tool in sorted(pathlib.Path(folder).glob("facetloc_*")):
        if tool.is_file() and os.access(tool, os.X_OK):
            commands = re.findall(r"^  ([a-z-]+) ", output(tool, "--help").partition("\nCommands:\n")[2], re.M)
            calls = [[command] for command in commands] or [[]]
            texts += [output(tool, *call, "--help-all") for call in calls]
    return " ".join(" ".join(texts).split())


def faults(found, folder):
    for_users = sum(p.is_for_users for p in found)
    if len(found) > MAXIMUM:
        yield f"{len(found)} parameters are more than {MAXIMUM}"
    sentence = f"there are {len(found)}, {for_users} of them for users"
    if sentence not in " ".join((ROOT / "CONTRIBUTING.md").read_text("utf-8").split()):
        yield f"CONTRIBUTING.md does not say: {sentence}"
    if folder:
        offered = help_of_tools(folder)
        for p in found:
            if p.struct not in OTHER_HELP and p.help not in offered:
                yield f"{p} is an option of no tool"


def main():
    found = parameters()
    problems = list(faults(found, sys.argv[1] if len(sys.argv) > 1 else ""))
    print(*problems, sep="\n", end="\n" if problems else "")
    print(f"{len(found)} parameters checked, {len(problems)} faults", file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
