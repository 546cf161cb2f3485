#!/usr/bin/env python3
"""One page of everything that was measured: what `stbvh-ab report` runs.

report.py -o DIR --program STBVH_AB --threads N [--from DIR] [--structures NAMES] [--quick]
          [--gallery] [--large-picture SCENE] [-- WORDS...]

Runs STBVH_AB for each part that --from does not have; WORDS are its options that say which scenes and how they are
made. Leaves in DIR: records/*.json, tables/*.txt, images, charts, index.html, which needs nothing else, and report.md
with the same. Without Debian's python3-matplotlib there are no charts, and the page says so. Prints the summary of each
part and where the page is.
"""
import argparse
import json
import os
import subprocess
import sys

import report_sections as sections
from page_blocks import Chart, Text
from page_html import html_page
from page_markdown import markdown_page
from record_files import distinct, fail, make_folder, read_bytes, read_file, run, write_whole

TITLE = "STBVH for Embree: measurements"
PARTS = ("bench", "error", "hard", "renders", "pareto", "truth")
GALLERY = "gallery"  # a part where it is asked for, or is there
STRUCTURES = "embree,embree-robust,embree-compact,embree-4v,lbvh,lbvh-4v,stbvh,stbvh-direct"
PICTURE_STRUCTURES = "embree,embree-4v,lbvh,stbvh,stbvh-direct"
RAYS = "primary,bounce,uniform,shadow,bounce-occluded,uniform-occluded"
FAMILIES = (  # the first twelve are those of speed against error
    "closed-2k-1,closed-2k-2,closed-2k-8,closed-2k-16,closed-2k-128,needles-1e4,needles-1e5,needles-1e6,slivers-1e4,"
    "slivers-1e5,slivers-1e6,offset-1e6,step-times-7,temporal-splits,time-ranges-touching,scale-1e-10,scale-1e10,origin-far,"
    "coplanar,zero-directions,fast-closed-16,half-turn,nan-rays,infinite-rays")


# --- measuring ---


class Measuring:
    """Makes the records of each part, by the program or from those that there are."""

    def __init__(self, arguments):
        self.a = arguments
        self.is_wrong = False
        self.machine_line = ""

    def path(self, *names):
        return os.path.join(self.a.output, *names)

    def record_file(self, part):
        return self.path("records", f"{part}.json")

    def take_records(self):
        """From --from, as a report leaves them or beside each other, with the pictures."""
        folder = self.a.from_folder
        if not os.path.isdir(folder):
            fail(f'--from: "{folder}" is not a folder.')
        for part in (*PARTS, GALLERY):
            inner = os.path.join(folder, "records", f"{part}.json")
            path = inner if os.path.lexists(inner) else os.path.join(folder, f"{part}.json")
            if os.path.lexists(path):
                read_file(path)
                self.copy(path, self.record_file(part))
                yield part
        images = os.path.join(folder, "images")
        for name in sorted(os.listdir(images)) if os.path.isdir(images) else ():
            if name.endswith(".png"):
                self.copy(os.path.join(images, name), self.path("images", name))

    def copy(self, source, target):
        if not (os.path.exists(target) and os.path.samefile(source, target)):
            write_whole(target, read_bytes(source))

    def command(self, part, words):
        """Runs the program with --json RECORDS at the end. Returns what it printed; ends the script if it failed."""
        file = self.record_file(part)
        if os.path.exists(file):
            os.unlink(file)
        sys.stdout.flush()
        done = subprocess.run([self.a.program, *words, "--json", file], stdout=subprocess.PIPE, text=True,
                              errors="replace", check=False)
        if done.returncode < 0:
            fail(f"stbvh-ab {words[0]} was ended by signal {-done.returncode}.", 1)
        if done.returncode > 1 or not os.path.exists(file):
            sys.exit(done.returncode or 1)
        self.is_wrong |= done.returncode == 1
        return done.stdout

    def show(self, text):
        """Prints a summary; what the machine is only once."""
        first, rest = text.split("\n", 1)
        print(text if first != self.machine_line else rest, end="", flush=True)
        self.machine_line = first

    def with_tables(self, part, words):
        self.show(self.command(part, words + ["--tables", self.path("tables", f"{part}.txt")]))

    def with_scenes(self, *words, threads=None):
        return [*words, *self.a.scene_words, "--threads", threads or self.a.threads]

    def structures(self, otherwise=STRUCTURES):
        return self.a.structures or otherwise

    def choose(self, whole, quick):
        return quick if self.a.quick else whole

    def bench(self):
        self.with_tables("bench", self.with_scenes(
            "bench", "--structures", self.structures(), "--rays", RAYS, "--count", self.choose("100000", "20000"),
            "--build-budget", self.choose("2", "0")))

    def error(self):
        self.with_tables("error", self.with_scenes("error", "--structures", self.structures(), "--count",
                                                   self.choose("20000", "2000")))

    def hard(self):
        self.with_tables("hard", ["hard", "--families", FAMILIES, "--structures", self.structures(), "--count",
                                  self.choose("20000", "2000"), "--threads", self.a.threads])

    def renders(self):
        words = ["render", "--structures", self.structures(PICTURE_STRUCTURES), "-o", self.path("images")]
        text = self.command("renders", self.with_scenes(
            *words, "--size", self.choose("384x216", "192x108"), "--spp", self.choose("8", "4")))
        made = read_json(self.record_file("renders"))
        if not self.a.quick and self.a.large_picture:
            scene_words = self.a.scene_words + (["--scenes"] if "--scenes" not in self.a.scene_words else [])
            at = scene_words.index("--scenes")
            scene_words[at:at + 2] = ["--scenes", self.a.large_picture]
            text += self.command("renders-large", [*words, *scene_words, "--threads", self.a.threads, "--size", "960x540",
                                                   "--spp", "64"])
            large = read_json(self.record_file("renders-large"))
            by_key = {(r["scene"], r["structure"]): r for r in made["records"] + large["records"]}
            made["records"] = list(by_key.values())
            made["command"] += "\n" + large["command"]
            write_whole(self.record_file("renders"), json.dumps(made, indent=1).encode())
            os.unlink(self.record_file("renders-large"))
        write_whole(self.path("tables", "renders.txt"), text.encode())

    def pareto(self):
        speeds, hards = (read_json(self.record_file(part))["records"] for part in ("bench", "hard"))
        if not {r["structure"] for r in speeds} & {r["structure"] for r in hards}:
            return
        text = self.command("pareto", ["pareto", "--from", f'{self.record_file("bench")},{self.record_file("hard")}'])
        write_whole(self.path("tables", "pareto.txt"), text.encode())

    def truth(self):
        text = self.command("truth", [
            "truth", "--scenes", "wheels", "--scale", "0.02", "--size", self.choose("192x108", "96x54"), "--spp",
            self.choose("256", "64"), "--frozen-times", self.choose("1024", "128"), "--threads", self.a.threads, "-o",
            self.path("images")])
        write_whole(self.path("tables", "truth.txt"), text.encode())

    def gallery(self):
        self.show(self.command(GALLERY, self.with_scenes(
            "gallery", "--no-pictures", "-o", self.path("tables", GALLERY), "--count", self.choose("20000", "2000"),
            "--repeats", self.choose("7", "3"), "--growth", self.choose("20000", "1000"), threads="1")))

    def run(self):
        for inner in ("records", "tables", "images", "charts"):
            make_folder(self.path(inner))
        taken = []
        if self.a.from_folder is not None:
            taken = list(self.take_records())
            if not taken:
                fail(f'--from: there are no records in "{self.a.from_folder}".')
        for part in (*PARTS, GALLERY) if self.a.gallery else PARTS:
            if part not in taken:
                getattr(self, part)()


def read_json(path):
    return json.loads(read_bytes(path))


# --- the page ---


def read_parts(measuring):
    return [{"name": part, **read_file(measuring.record_file(part))} for part in (*PARTS, GALLERY)
            if os.path.exists(measuring.record_file(part))]


def drawn_charts(records, of_gallery, folder):
    """Charts by name; None without matplotlib."""
    try:
        import chart_tools
    except ImportError:
        return None
    import charts
    import gallery_charts
    import plot_pareto

    drawings = list(charts.charts(records)) + list(gallery_charts.charts(of_gallery))
    pareto = [r for r in records if r["kind"] == "pareto"]
    if pareto:
        drawings.append(("pareto", lambda: plot_pareto.draw_pareto(pareto)))
    found = {}
    for name, draw in drawings:
        path = f"charts/{charts.file_name(name)}.svg"
        figure = draw()
        title = figure._suptitle.get_text()
        chart_tools.save(figure, os.path.join(folder, path))
        found[name] = Chart(path, title)
    return found


def chosen_records(files):
    """Of kinds that several parts hold (pareto has a bench and hard cases of its own), those of the first.

    The gallery's are its own.
    """
    chosen = []
    kinds = set()
    for file in files:
        if file["name"] == GALLERY:
            continue
        chosen += [r for r in file["records"] if r["kind"] not in kinds]
        kinds |= {r["kind"] for r in file["records"]}
    return chosen


def records_of_gallery(files):
    return [r for file in files if file["name"] == GALLERY for r in file["records"]]


def page_sections(files, charts):
    records = chosen_records(files)
    kinds = {r["kind"] for r in records}
    structures = distinct(r["structure"] for r in records if "structure" in r)
    makers = (("speed", lambda: sections.speed(records, charts)), ("build", lambda: sections.memory(records, charts)),
              ("error", lambda: sections.error(records)), ("hard", lambda: sections.hard(records)),
              ("pareto", lambda: sections.pareto(records, charts)), ("render", lambda: sections.renders(records)),
              ("truth", lambda: sections.truth(records, charts)))
    found = [sections.summary(records, structures)] + [make() for kind, make in makers if kind in kinds]
    found += [sections.gallery(records_of_gallery(files), charts)] if records_of_gallery(files) else []
    return found + [sections.reproduce(files)]


def write_page(measuring):
    folder = measuring.a.output
    files = read_parts(measuring)
    subtitle = "; ".join(distinct(f["records"][0]["origin"] for f in files))
    charts = drawn_charts(chosen_records(files), records_of_gallery(files), folder)
    found = page_sections(files, charts or {})
    if charts is None:
        found[0].blocks.append(Text("There are no charts on this page: Debian's `python3-matplotlib` is missing."))
    page = html_page(TITLE, subtitle, found, folder)
    write_whole(measuring.path("report.md"), markdown_page(TITLE, subtitle, found).encode())
    write_whole(measuring.path("index.html"), page.encode())
    print(f'\nthe page: {measuring.path("index.html")} (and report.md beside it)\n'
          f'records:  {measuring.path("records")}   all tables: {measuring.path("tables")}')


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="made if it is not there")
    parser.add_argument("--program", required=True)
    parser.add_argument("--threads", required=True)
    parser.add_argument("--from", dest="from_folder", metavar="DIR")
    parser.add_argument("--structures")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--gallery", action="store_true")
    parser.add_argument("--large-picture", metavar="SCENE",
                        help="of WORDS, rendered once more with many samples: how long a picture takes")
    parser.add_argument("scene_words", nargs="*")
    measuring = Measuring(parser.parse_args())
    measuring.run()
    write_page(measuring)
    if measuring.is_wrong:
        fail("Wrong answers of our structures: see above, and the page.", 1)


if __name__ == "__main__":
    run(main)
