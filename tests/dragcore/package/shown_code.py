"""Checks that C++ shown in the documentation is part of an example that CI compiles and runs: lines in the same order, all in one file.

Usage: shown_code.py REPOSITORY
"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
examples = {path.name: [line.strip() for line in path.read_text().splitlines()] for path in (root / "dragcore/examples").glob("*.c*")}


def first_line_missing(block, example):
    remaining = iter(example)
    return next((line for line in block if line not in remaining), None)


count = 0
for page in [root / "README.md", *(root / "docs").glob("*.md")]:
    for block in re.findall(r"```cpp\n(.*?)```", page.read_text(), re.DOTALL):
        lines = [line.strip() for line in block.splitlines() if line.strip()]
        missing = {name: first_line_missing(lines, example) for name, example in examples.items()}
        if None not in missing.values():
            sys.exit(f"{page}: this code is in no example of dragcore/examples, in this order:\n{block}first line that is missing: {missing}")
        count += 1
if count < 3:
    sys.exit(f"only {count} blocks of C++ were found: is the search broken?")
print(f"{count} blocks of C++ are parts of examples")
