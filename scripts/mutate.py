#!/usr/bin/env python3
"""Puts one fault into one line of libs/, the same one for the same seed.

  scripts/mutate.py TREE SEED [LIBRARY...]

Kinds, in turn by the seed: a sign, an index, a unit (a factor), a missing term. Prints
`LIBRARY FILE:LINE KIND: old -> new`, and changes the file below TREE.
"""
import pathlib
import random
import re
import sys

NUMBER = r"(?<![\w.])(\d+(?:\.\d*)?(?:e[-+]?\d+)?)(?![\w.])"


def signs(line):
    for m in re.finditer(r"(?<=[\w)\]]) ([-+]) (?=[\w(])", line):
        yield line[:m.start(1)] + ("-" if m.group(1) == "+" else "+") + line[m.end(1):]
    for m in re.finditer(r" ([-+])= ", line):
        yield line[:m.start(1)] + ("-" if m.group(1) == "+" else "+") + line[m.end(1):]
    for m in re.finditer(r"(?:return |= |\()(-)(?=[a-zA-Z(])", line):
        yield line[:m.start(1)] + line[m.end(1):]


def indices(line):
    other = {"x": "y", "y": "z", "z": "x"}
    for m in re.finditer(r"\.([xyz])\(\)", line):
        yield line[:m.start(1)] + other[m.group(1)] + line[m.end(1):]
    for m in re.finditer(r"[\[(](\d)(?=[\],)])", line):
        yield line[:m.start(1)] + str((int(m.group(1)) + 1) % 3) + line[m.end(1):]
    for m in re.finditer(r"(?<=\w)( [-+] 1)(?=[\])])", line):
        yield line[:m.start(1)] + line[m.end(1):]


def units(line):
    for m in re.finditer(r"\* " + NUMBER, line):
        yield line[:m.start(1)] + f"{2 * float(m.group(1)):g}" + line[m.end(1):]
    for m in re.finditer(NUMBER + r" [*/]", line):
        yield line[:m.start(1)] + f"{2 * float(m.group(1)):g}" + line[m.end(1):]
    for m in re.finditer(r"toSeconds\(", line):
        yield line[:m.start()] + "1e3 * " + line[m.start():]
    for m in re.finditer(r"std::(sqrt|abs)\(", line):
        yield line[:m.start()] + "2 * " + line[m.start():]


def terms(line):
    for m in re.finditer(r" [-+] [\w.\[\]()>:-]+(?=[;,)])", line):
        text = m.group()
        while text.count(")") > text.count("("):
            text = text[:text.rindex(")")]
        if text.count("(") == text.count(")"):
            yield line[:m.start()] + line[m.start() + len(text):]
    for m in re.finditer(r"(?<=[\w)]) \* [\w.]+(?=;)", line):
        yield line[:m.start()] + line[m.end():]


KINDS = [("sign", signs), ("index", indices), ("unit", units), ("term", terms)]


def is_code(line):
    return line.startswith("  ") and '"' not in line and "//" not in line


def faults(tree, kind, libraries):
    out = []
    for lib in libraries:
        for file in sorted((tree / "libs" / lib / "src").glob("*.cpp")):
            for number, line in enumerate(file.read_text().split("\n"), 1):
                if not is_code(line):
                    continue
                out += [(lib, file, number, line, new) for new in kind(line) if new != line]
    return out


def main():
    if len(sys.argv) < 3 or not sys.argv[2].isdigit():
        sys.exit(__doc__)
    tree, seed = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    libraries = sys.argv[3:] or sorted(p.parent.name for p in (tree / "libs").glob("*/src"))
    name, kind = KINDS[seed % len(KINDS)]
    rng = random.Random(seed)
    # First the library, so that a large one is not all that is tested.
    found = []
    while not found and libraries:
        lib = rng.choice(libraries)
        found = faults(tree, kind, [lib])
        libraries = [x for x in libraries if x != lib]
    if not found:
        sys.exit("mutate: no line for a fault of this kind")
    lib, file, number, old, new = rng.choice(found)
    lines = file.read_text().split("\n")
    lines[number - 1] = new
    file.write_text("\n".join(lines))
    print(f"{lib} {file.relative_to(tree)}:{number} {name}: {old.strip()} -> {new.strip()}")


if __name__ == "__main__":
    main()
