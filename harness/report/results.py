#!/usr/bin/env python3
"""Records of several machines side by side, as Markdown: what `stbvh-ab results` runs.

results.py RECORDS.json... -o PAGE

Reads what bench, error and hard wrote. In a file that has the two marker lines below, only what stands between them is
replaced. Records from a tree with uncommitted changes are refused.
"""
import argparse
import re
from statistics import geometric_mean

from page_blocks import Section, Table, Text
from page_markdown import write
from record_files import check_distinct, distinct, earlier_file, fail, grouped, machine_type, read_file, run, write_whole
from report_sections import HARD, REFERENCE, WRONG, in_words, number, ours_among, together

BEGIN, END = "<!-- made by stbvh-ab results: begin -->", "<!-- made by stbvh-ab results: end -->"


class Machine:
    """The records that were measured on one machine with one Embree."""

    def __init__(self, files):
        self.facts = files[0]["machine"]
        self.name = f'{short_name(self.facts["cpu"])}, Embree {self.facts["embree"]}'
        self.commits = distinct(f["commit"] for f in files)
        self.records = [r for f in files for r in f["records"]]
        check_distinct(self.records)
        self.speeds = [r for r in self.of("summary") if r["measure"] == "speed" and r["reference"] == REFERENCE]

    def of(self, kind):
        return [r for r in self.records if r["kind"] == kind]

    def threads(self):
        return sorted(distinct(r["threads"] for r in self.speeds))


def short_name(cpu):
    return re.sub(r"\s+", " ", re.sub(r"\((R|TM)\)|\d+-Core|Processor|CPU|@.*", "", cpu)).strip()


def read_machines(paths):
    files = [read_file(path) for path in paths]
    for path, file in zip(paths, files):
        if file["commit"].endswith("-dirty") or file["commit"] == "unknown":
            fail(f'"{path}" was not measured on a clean commit, but on "{file["commit"]}".')
    machines = {}
    for file in files:
        machines.setdefault(machine_type(file), []).append(file)
    return [Machine(group) for group in machines.values()]


def side_by_side(columns, caption):
    """A table of structures: columns are pairs of a heading and what it says of each structure."""
    names = distinct(name for _, cells in columns for name in cells)
    rows = [[f"`{name}`"] + [cells.get(name, "-") for _, cells in columns] for name in names]
    return Table(["structure"] + [heading for heading, _ in columns], rows, caption, ours_among(names))


def machine_table(machines):
    rows = [[m.name, str(m.facts["cores"]), f'{m.facts["memory_gb"]:.0f}', m.facts["instruction_set"],
             ", ".join(m.commits), ", ".join(distinct(r["scene"] for r in m.of("build")))] for m in machines]
    return Table(["machine", "cores", "GB", "our instruction set", "commit", "scenes"], rows)


def speed_columns(machines, key, text):
    """`text` of the records of each machine and thread count, for the kinds of rays `key`."""
    for machine in machines:
        for threads in machine.threads():
            found = {r["structure"]: text(r) for r in machine.speeds if r["rays"] == key and r["threads"] == threads}
            yield f'{machine.name}, {threads} thread{"s" if threads > 1 else ""}', found


def speed_sections(machines):
    joint = together([r for m in machines for r in m.speeds])
    if joint is None:
        return
    yield Section("speed", f"Speed against `{REFERENCE}`, {in_words(joint)}", [
        side_by_side(list(speed_columns(machines, joint, lambda r: f'{r["mean_ratio"]:.2f} ({r["mean_ratio_min"]:.2f} to '
                                                                  f'{r["mean_ratio_max"]:.2f})')),
                     "Geometric mean over the scenes; in brackets its least and largest in a repeat."),
        side_by_side(list(speed_columns(machines, joint, lambda r: f'{r["worst_ratio"]:.2f} {r["worst_scene"]}')),
                     "The scene in which each is slowest.")])
    kinds = [k for k in distinct(r["rays"] for m in machines for r in m.speeds) if k != joint and "occluded" not in k]
    columns = [(f"{rays}: {m.name}", {r["structure"]: f'{r["mean_ratio"]:.2f}' for r in m.speeds
                                      if r["rays"] == rays and r["threads"] == m.threads()[-1]})
               for rays in kinds for m in machines if m.speeds]
    if columns:
        yield Section("kinds", "Speed by kind of rays", [side_by_side(columns, "With the most threads.")])


def rates(machine, kinds):
    """Million rays a second of each structure, one thread, geometric mean over scenes and `kinds` of rays."""
    records = [r for r in machine.of("speed") if r["threads"] == 1 and r["rays"] in kinds]
    return {name: geometric_mean([r["mrays_per_s"] for r in group]) for (name,), group in grouped(records, "structure").items()}


def version_sections(machines):
    """Where one machine has several Embrees: how fast each is by itself."""
    joint = together([r for m in machines for r in m.speeds])
    groups = {}
    for machine in machines:
        groups.setdefault((machine.facts["cpu"], machine.facts["cores"]), []).append(machine)
    groups = [group for group in groups.values() if len(group) > 1]
    if joint is None or not groups:
        return
    columns = [(m.name, {name: f"{rate:.3f}" for name, rate in rates(m, joint.split("+")).items()})
               for group in groups for m in group]
    yield Section("versions", f"Embree's versions on one machine, million rays a second, {in_words(joint)}", [
        side_by_side(columns, "One thread; geometric mean over scenes and kinds of rays, the same rays in all. Not interleaved: "
                              "each as its own records were measured, with its system's compiler. What our kernels alone "
                              "(`stbvh-direct`) differ by is not Embree's.")])


def build_sections(machines):
    columns = []
    for machine in machines:
        for measure, words in (("structure_bytes", "bytes"), ("build_s", "build time")):
            columns.append((f"{words}: {machine.name}", {
                r["structure"]: f'{r["mean_ratio"]:.2f}, most {r["worst_ratio"]:.2f} {r["worst_scene"]}'
                for r in machine.of("summary") if r["measure"] == measure and r["reference"] == REFERENCE}))
    if any(cells for _, cells in columns):
        yield Section("build", f"Bytes and build time against `{REFERENCE}`", [side_by_side(columns, "Less is better.")])


def counted(records, keys, count="traced"):
    """Wrong answers of each structure, of how many rays."""
    found = {}
    for (name,), group in grouped(records, "structure").items():
        traced = sum(r[count] for r in group)
        wrong = sum(r[key] or 0 for r in group for key, _ in keys)
        found[name] = f"{number(wrong)} of {number(traced)}"
    return found


def error_sections(machines):
    columns = []
    for m in machines:
        leaks = [r for r in m.of("hard") if r["leaks"] is not None]
        for words, cells in (("wrong answers", counted(m.of("error"), WRONG)),
                             ("leaks, closed meshes", counted(leaks, HARD[:1])),
                             ("wrong answers, hard cases", counted(m.of("hard"), WRONG))):
            if cells:
                columns.append((f"{words}: {m.name}", cells))
    if columns:
        yield Section("error", "Errors against an exact oracle", [
            side_by_side(columns, "Beyond rounding. No error in n rays means an error rate below 3 / n with 95 % confidence.")])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("records", nargs="+", metavar="RECORDS.json")
    parser.add_argument("-o", "--output", required=True, metavar="FILE.md")
    arguments = parser.parse_args()
    machines = read_machines(arguments.records)
    sections = [*speed_sections(machines), *version_sections(machines), *build_sections(machines), *error_sections(machines)]
    if not sections:
        fail("There is nothing to show: no summaries of bench, no records of error and hard.")
    text = "\n\n".join([write(machine_table(machines))] + [write(section) for section in sections])
    earlier = earlier_file(arguments.output)
    page = f"{BEGIN}\n{END}\n" if earlier is None else earlier.decode(errors="surrogateescape")
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        fail(f'"{arguments.output}" does not have the lines "{BEGIN}" and "{END}".')
    write_whole(arguments.output, f"{before}{BEGIN}\n\n{text}\n\n{END}{after}".encode(errors="surrogateescape"))
    print(arguments.output, flush=True)


if __name__ == "__main__":
    run(main)
