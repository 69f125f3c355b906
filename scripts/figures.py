#!/usr/bin/env python3
"""Figures of the code base: lines per crate, long functions, public items, long sentences, wide comments.

    python3 scripts/figures.py [ROOT]

Reads the Rust files under `crates/` and `src/` of ROOT (this repository by default) as text. Unit tests are counted
apart: they follow the first `#[cfg(test)]` of a file or lie in files named `tests.rs`, `*_tests.rs` or under `tests/`.
Cloned code is measured by a public detector:
`npx jscpd@4 --min-lines 8 --min-tokens 60 --format rust crates src`.
"""

import re
import sys
from collections import Counter
from pathlib import Path

LONG_FUNCTION = 60
LONG_SENTENCE = 30


def is_test_file(path):
    return path.name == "tests.rs" or path.name.endswith("_tests.rs") or "tests" in path.parts


def crate_of(path, root):
    parts = path.relative_to(root).parts
    return parts[1] if parts[0] == "crates" else f"src/{parts[1]}" if len(parts) > 2 else "src"


def blank_literals(line):
    line = re.sub(r'"(\\.|[^"\\])*"', '""', line)
    return re.sub(r"'(\\.|[^'\\])'", "' '", line)


def function_lengths(lines):
    """Yields name and length, in lines, of each function with a body."""
    at = 0
    while at < len(lines):
        match = re.match(r"\s*(?:pub(?:\([a-z ]+\))? )?(?:const |unsafe |extern \"C\" )*fn (\w+)", lines[at])
        if match:
            depth, opened = 0, False
            for end in range(at, len(lines)):
                code = blank_literals(lines[end].split("//")[0])
                if not opened and "{" not in code and code.rstrip().endswith(";"):
                    break
                opened = opened or "{" in code
                depth += code.count("{") - code.count("}")
                if opened and depth <= 0:
                    yield match[1], end - at + 1
                    break
        at += 1


def sentences(lines):
    """Yields the number of words of each sentence of doc comments."""
    text, is_fenced = "", False
    for line in [*lines, ""]:
        match = re.match(r"\s*//[/!] ?(.*)", line)
        words = match[1].strip() if match else ""
        if words.startswith("```"):
            is_fenced = not is_fenced
            words = ""
        if not match or is_fenced or not words or words.startswith(("|", "#", "-", "*")):
            yield from (len(part.split()) for part in re.split(r"(?<=[.?!])\s+(?=[A-Z`\[])", text) if part.split())
            text = words.lstrip("-* ") if words.startswith(("-", "*")) else ""
        else:
            text += " " + words


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent).resolve()
    code, tests, comments = Counter(), Counter(), Counter()
    functions, long_sentences, all_sentences, public, wide, files = [], 0, 0, 0, 0, 0
    for path in sorted([*root.glob("crates/*/src/**/*.rs"), *root.glob("src/**/*.rs")]):
        lines = path.read_text().splitlines()
        crate = crate_of(path, root)
        files += 1
        split = len(lines) if not is_test_file(path.relative_to(root)) else 0
        for number, line in enumerate(lines[:split]):
            if line.strip().startswith("#[cfg(test)]"):
                split = number
                break
        for number, line in enumerate(lines):
            text = line.strip()
            if not text:
                continue
            is_comment = text.startswith("//")
            (tests if number >= split else comments if is_comment else code)[crate] += 1
            wide += is_comment and len(line) > 100
        functions += [(length, name, path.relative_to(root)) for name, length in function_lengths(lines[:split])]
        public += sum(bool(re.match(r"\s*pub (?:const )?(?:unsafe )?(?:fn|struct|enum|trait|type|const|static|mod) ", line))
                      for line in lines[:split])
        lengths = list(sentences(lines[:split]))
        all_sentences += len(lengths)
        long_sentences += sum(length > LONG_SENTENCE for length in lengths)
    print(f"{'crate or folder':24}{'code':>8}{'comments':>10}{'unit tests':>12}")
    for crate in sorted(code):
        print(f"{crate:24}{code[crate]:8}{comments[crate]:10}{tests[crate]:12}")
    print(f"{'all':24}{code.total():8}{comments.total():10}{tests.total():12}")
    functions.sort(reverse=True)
    long = [function for function in functions if function[0] > LONG_FUNCTION]
    print(f"files {files}, functions {len(functions)}, of more than {LONG_FUNCTION} lines {len(long)}")
    for length, name, path in long:
        print(f"    {length:4} {name} ({path})")
    print(f"public items (`pub fn`, `struct`, `enum`, …) {public}")
    print(f"sentences of heads and doc lines {all_sentences}, of more than {LONG_SENTENCE} words {long_sentences}")
    print(f"comment lines wider than 100 columns {wide}")


if __name__ == "__main__":
    main()
