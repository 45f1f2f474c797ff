# SPDX-License-Identifier: BSD-3-Clause
"""What documents tell their readers to type: commands and code, in the order in which they stand there."""
import re


class Document:
    def __init__(self, path):
        self.path = path
        self.lines = path.read_text(encoding="utf-8").splitlines()

    def section(self, heading):
        """The lines below a heading, down to the next one of its level."""
        try:
            begin = next(i for i, line in enumerate(self.lines) if re.fullmatch(f"#+ {re.escape(heading)}", line))
        except StopIteration:
            raise SystemExit(f"{self.path} has no section '{heading}'") from None
        level = len(self.lines[begin].split()[0])
        ends = (i for i, line in enumerate(self.lines[begin + 1:], begin + 1) if re.match(f"#{{1,{level}}} ", line))
        return self.lines[begin + 1:next(ends, None)]

    def commands(self, heading):
        """Indented lines that begin with one of our programs, without the remarks behind them."""
        programs = re.compile(r" {4}(?:\w+=\S+ )*(?:facetloc\b|facetloc_|apps/examples/|echo |cmake )")
        found = [re.sub(r"  +#.*", "", line).strip() for line in self.section(heading) if programs.match(line)]
        if not found:
            raise SystemExit(f"{self.path}: section '{heading}' has no commands")
        return found

    def code(self, heading, language):
        """The blocks of code in a language."""
        blocks = re.findall(rf"^```{re.escape(language)}\n(.*?)^```", "\n".join(self.section(heading)), re.MULTILINE | re.DOTALL)
        if not blocks:
            raise SystemExit(f"{self.path}: section '{heading}' has no code in {language}")
        return blocks
