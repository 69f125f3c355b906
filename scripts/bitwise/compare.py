#!/usr/bin/env python3
"""Compares two manifests of record.sh: prints each result that differs, and a verdict.

Ends with code 1 if there is a difference.
"""

import argparse
import sys


def read(path):
    manifest = {}
    with open(path, encoding="utf-8") as file:
        for line in file:
            if line.startswith("#") or not line.strip():
                continue
            key, total, *columns = line.rstrip("\n").split("\t")
            listed = columns[0].split("; ") if columns and columns[0] else []
            pairs = (pair.rsplit("=", 1) for pair in listed)
            manifest[key] = (total, dict(pairs))
    return manifest


def difference(before, after):
    """The names of the columns that differ, or None if all data are equal."""
    (total_before, columns_before), (total_after, columns_after) = before, after
    same_names = columns_before.keys() == columns_after.keys()
    if same_names and columns_before:
        # Also finds two columns that were exchanged, which the sum of a file does not show.
        names = [name for name, part in columns_before.items() if columns_after[name] != part]
        if names or total_before != total_after:
            return ", ".join(names) or "columns that are not listed"
        return None
    if total_before == total_after:
        return None
    gone = [name for name, part in columns_before.items() if part not in columns_after.values()]
    new = [name for name, part in columns_after.items() if part not in columns_before.values()]
    if not gone and not new:
        return f"{total_before} before, {total_after} after"
    return f"only before: {', '.join(gone) or 'none'}; only after: {', '.join(new) or 'none'}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("before", help="manifest of the build from before the change")
    parser.add_argument("after", help="manifest of the build from after the change")
    arguments = parser.parse_args()
    before, after = read(arguments.before), read(arguments.after)
    different = 0
    for key in [*before, *(key for key in after if key not in before)]:
        if key not in after:
            what = "missing after"
        elif key not in before:
            what = "missing before"
        else:
            what = difference(before[key], after[key])
        if what:
            different += 1
            print(f"{key}: {what}")
    total = len(before.keys() | after.keys())
    if not before or not after:
        print("FAILED: a manifest is empty")
    elif different:
        print(f"DIFFERENT: {different} of {total} results")
    else:
        print(f"EQUAL: all {total} results, bit by bit")
    sys.exit(1 if different or not before or not after else 0)


if __name__ == "__main__":
    main()
