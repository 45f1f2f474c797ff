#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Compares the tables of constants in the METHOD documents with the source: check_methods.py [ROOT]

A row `constant | value | where | why | chosen on` is of what `Struct::field` or `file.cpp:kName` is set to. Each number of the
value has a name in the third column, in the same order; it is compared as precisely as it is written."""
import ast
import math
import operator
import pathlib
import re
import sys

HEAD = ["constant", "value", "where", "why", "chosen on"]
MODULES = ("features", "segmentation", "registration", "io", "apps")
OPERATORS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv}
NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"


def chi_square_quantile(freedom, probability):
    """By bisection of the series of the incomplete gamma function."""
    def below(x):
        a, x = freedom / 2, x / 2
        term = total = 1 / a
        for n in range(1, 500):
            term *= x / (a + n)
            total += term
        return total * math.exp(a * math.log(x) - x - math.lgamma(a))
    low, high = 1e-9, 200.0
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if below(middle) < probability else (low, middle)
    return low


class Source:
    """What constants and defaults are set to in the files of all modules."""

    def __init__(self, root):
        self.files = {}
        for module in MODULES:
            for path in sorted((root / module).rglob("*")):
                if path.suffix in (".h", ".hpp", ".cpp"):
                    self.files.setdefault(path.name, []).append(re.sub(r"//[^\n]*", "", path.read_text("utf-8")))
        self.structs = {}
        for texts in self.files.values():
            for text in texts:
                for name, body in re.findall(r"\bstruct (\w+)[^{};()]*\{(.*?)\n\};", text, re.DOTALL):
                    self.structs.setdefault(name, []).append(body)

    def expressions(self, reference):
        """The texts after the equals sign, of which there must be one; those of an array by elements."""
        if "::" in reference:
            owner, name = reference.split("::")
            texts = self.structs.get(owner, [])
        else:
            owner, name = reference.split(":")
            texts = self.files.get(owner, [])
        if len(texts) != 1:
            raise ValueError(f"{owner} is in {len(texts)} places")
        found = re.findall(rf"\b{name}\s*(?:=\s*)?\{{([^}};]+)\}};|\b{name}\s*=\s*((?:[^,;()]|\([^()]*\))+)[,;]", texts[0])
        if len(found) != 1:
            raise ValueError(f"{reference} is set in {len(found)} places")
        listed, single = found[0]
        return [text.strip() for text in listed.split(",")] if listed else [single.strip()]

    def values(self, reference):
        return [self.value(text, reference) for text in self.expressions(reference)]

    def value(self, text, reference):
        if text in ("true", "false"):
            return text
        if re.fullmatch(r"\w+::\w+", text):  # a choice
            return text.split("::")[1]
        text = re.sub(r"static_cast<\w+>|(?<=\d)f\b", "", text)
        return self.evaluate(ast.parse(text, mode="eval").body, reference)

    def evaluate(self, node, reference):
        if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
            return node.value
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return -self.evaluate(node.operand, reference)
        if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
            return OPERATORS[type(node.op)](self.evaluate(node.left, reference), self.evaluate(node.right, reference))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "chiSquareQuantile":
            return chi_square_quantile(*(self.evaluate(argument, reference) for argument in node.args))
        if isinstance(node, ast.Name):
            if node.id == "kDegree":  # documents have degrees
                return 1
            for file, texts in self.files.items():
                if any(re.search(rf"\bconstexpr \w+ (?:\w+ = [^;]*, )?{node.id} =", text) for text in texts):
                    return self.values(f"{file}:{node.id}")[0]
        raise ValueError(f"{reference} is not set to a number")


def rows(path):
    """Line, constant, value and references of each row of a table of constants."""
    inside = False
    for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")] if line.startswith("|") else []
        if cells == HEAD:
            inside = True
        elif not cells:
            inside = False
        elif inside and not line.startswith("|---"):
            yield number, cells


def fault(source, cells):
    """What is wrong with a row; empty if nothing is."""
    if len(cells) != len(HEAD):
        return f"{len(cells)} cells instead of {len(HEAD)}"
    references = re.findall(r"`(\w+::\w+|[\w.]+:\w+)`", cells[2])
    if not references:
        return "the third column names no constant of the source"
    try:
        values = [value for reference in references for value in source.values(reference)]
    except (ValueError, SyntaxError) as error:
        return str(error)
    if isinstance(values[0], str):
        written = [cells[1].strip("`")]
    else:
        written = re.findall(NUMBER, cells[1])[:len(values)]
    if len(written) != len(values):
        return f"{len(written)} numbers for {len(values)} constants"
    wrong = [f"{value:g}" if not isinstance(value, str) else value for text, value in zip(written, values) if not same(text, value)]
    return f"{cells[1]} is {', '.join(wrong)} in the source" if wrong else ""


def same(text, value):
    if isinstance(value, str):
        return text == value
    mantissa, _, exponent = text.partition("e")
    last_digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return abs(float(text) - value) <= 0.5000001 * last_digit if "." in mantissa else math.isclose(float(text), value)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent)
    source, checked, faults = Source(root), 0, 0
    for path in sorted(root.glob("*/METHOD.md")) + sorted(root.glob("registration/*/METHOD.md")):
        for number, cells in rows(path):
            checked += 1
            problem = fault(source, cells)
            if problem:
                faults += 1
                print(f"{path.relative_to(root)}:{number}: {cells[0]}: {problem}")
    print(f"{checked} constants of METHOD documents checked, {faults} faults", file=sys.stderr)
    return 1 if faults or checked < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
