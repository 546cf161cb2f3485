#!/usr/bin/env python3
"""Hard cases as a Markdown table, one row for each family: hard_table.py RECORDS.json [STRUCTURE...]

Reads the records of kind "hard" that `stbvh-ab hard` writes. A cell has what is not zero of: leaks, missed,
false hits, wrong primitives, wrong answers of any hit; then, after ~, answers that differ where the exact one
changes within rounding, ties with another triangle than the exact one, rays that meet the triangle which they
leave, and 99th percentiles of the error of t: relative, and in spacings of floats. "-" stands for a
structure that cannot be asked.
"""
import sys

from record_files import read_records, run

DEFAULT = ("stbvh-direct", "stbvh", "embree", "embree-robust", "embree-4v")
COUNTS = (
    ("leaks", "leaks"),
    ("missed", "missed"),
    ("false_hits", "false"),
    ("wrong_primitive", "wrong"),
    ("any_hit_wrong", "any hit"),
)


def cell(record):
    if record is None:
        return "-"
    found = [f"**{record[key]} {word}**" for key, word in COUNTS if record[key]]
    text = ", ".join(found) if found else "0"
    if record["within_rounding"]:
        text += f' ~{record["within_rounding"]}'
    if record["ties"]:
        text += f' ({record["ties"]} ties)'
    if record["self_hits"] is not None:
        text += f' {record["self_hits"]} self'
    errors = [record["t_error_rel_p99"], record["t_error_ulps_p99"]]
    relative, ulps = (f"{e:.0e}" if e is not None else "inf" for e in errors)
    return f"{text}; {relative}, {ulps}"


def main(path, structures):
    records = [r for r in read_records([path]) if r["kind"] == "hard"]
    by_key = {(r["family"], r["structure"]): r for r in records}
    print("| family | " + " | ".join(structures) + " |")
    print("|---" * (len(structures) + 1) + "|")
    for family in dict.fromkeys(r["family"] for r in records):
        cells = [cell(by_key.get((family, s))) for s in structures]
        print(f"| {family} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: hard_table.py RECORDS.json [STRUCTURE...]")
    run(lambda: main(sys.argv[1], sys.argv[2:] or DEFAULT))
