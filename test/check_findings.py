#!/usr/bin/env python3
"""Compares the ids of findings in the source with the list in apps/FINDINGS.md."""
import re
import subprocess
import sys

sources = subprocess.run(["git", "ls-files", "*.cpp", "*.h", ":!test"], capture_output=True, text=True,
                         check=True).stdout.split()
made = {}
for source in sources:
    with open(source, encoding="utf-8") as file:
        text = file.read()
    for match in re.finditer(r'"([a-z]+\.[a-z_]+)"(?=\s*[:,][^;]{0,160}?(?:Severity::|severity,))', text):
        made.setdefault(match.group(1), source)
with open("apps/FINDINGS.md", encoding="utf-8") as file:
    listed = set(re.findall(r"^\| `([a-z]+\.[a-z_]+)` \|", file.read(), re.M))
faults = [f"{source}: {finding} is not in apps/FINDINGS.md" for finding, source in made.items() if finding not in listed]
faults += [f"apps/FINDINGS.md: {finding} is made nowhere" for finding in sorted(listed - made.keys())]
print("\n".join(faults) or f"{len(made)} findings are listed")
sys.exit(bool(faults) or not made)
