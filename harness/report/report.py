#!/usr/bin/env python3
"""One page of everything that was measured: report.py DIR

Reads DIR/records/*.json, which stbvh-ab wrote, and the pictures that they name below DIR. Writes DIR/index.html,
which needs nothing else, DIR/report.md with the same, and DIR/charts. Without Debian's python3-matplotlib there are
no charts, and the page says so. Prints the files' names.
"""
import os
import sys

import report_sections as sections
from page_blocks import Chart, Section, Text
from page_html import html_page
from page_markdown import markdown_page
from record_files import distinct, fail, read_file, run, write_whole

TITLE = "STBVH for Embree: measurements"
PARTS = ("bench", "error", "hard", "pareto", "renders", "truth")


def read_parts(folder):
    """The files of the parts that there are."""
    files = []
    for name in PARTS:
        path = os.path.join(folder, "records", f"{name}.json")
        if os.path.exists(path):
            files.append({"name": name, **read_file(path)})
    if not files:
        fail(f'There are no records in "{os.path.join(folder, "records")}".')
    return files


def drawn_charts(records, folder):
    """Charts by name; empty without matplotlib."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        return None
    import charts
    import chart_tools
    import plot_pareto

    os.makedirs(os.path.join(folder, "charts"), exist_ok=True)
    drawings = list(charts.charts(records))
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
    """Of kinds that several parts hold (pareto has a bench and hard cases of its own), those of the first."""
    chosen = []
    kinds = set()
    for file in files:
        chosen += [r for r in file["records"] if r["kind"] not in kinds]
        kinds |= {r["kind"] for r in file["records"]}
    return chosen


def page_sections(files, charts):
    records = chosen_records(files)
    kinds = {r["kind"] for r in records}
    structures = distinct(r["structure"] for r in records if "structure" in r)
    makers = (("speed", lambda: sections.speed(records, charts)), ("build", lambda: sections.memory(records, charts)),
              ("error", lambda: sections.error(records)), ("hard", lambda: sections.hard(records)),
              ("pareto", lambda: sections.pareto(records, charts)), ("render", lambda: sections.renders(records)),
              ("truth", lambda: sections.truth(records, charts)))
    found = [sections.summary(records, structures)] + [make() for kind, make in makers if kind in kinds]
    return found + [sections.reproduce(files)]


def write(path, text):
    write_whole(path, text.encode())
    print(path, flush=True)


def main(folder):
    files = read_parts(folder)
    subtitle = "; ".join(distinct(f["records"][0]["origin"] for f in files))
    charts = drawn_charts(chosen_records(files), folder)
    found = page_sections(files, charts or {})
    if charts is None:
        found[0].blocks.append(Text("There are no charts on this page: Debian's `python3-matplotlib` is missing."))
    page = html_page(TITLE, subtitle, found, folder)
    write(os.path.join(folder, "report.md"), markdown_page(TITLE, subtitle, found))
    write(os.path.join(folder, "index.html"), page)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: report.py DIR")
    run(lambda: main(sys.argv[1]))
