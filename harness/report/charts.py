#!/usr/bin/env python3
"""Charts of the records that `stbvh-ab bench`, `scaling`, `edits` and `gallery` write.

charts.py RECORDS.json... -o DIR [--structures NAME,...] [--format svg|png]

Speed in each scene and over all, bytes, build time; scaling over steps, triangles, threads, bytes and tolerance; edits:
whatever the records hold. The functions that draw take records and return a figure; charts() says which file each goes to.
Prints the files' names.
"""
import argparse
import math
import os
import re

import gallery_charts
from chart_tools import finish, log_scale, plt, save, styles, whiskers
from record_files import check_distinct, distinct, fail, grouped, make_folder, read_records, run

REFERENCE = "embree"
KINDS = ("build", "speed", "summary", "scaling", "edit", "frames", "truth", "gallery", "slice")  # of records that are drawn here
PANELS_ABREAST = 3
PANEL_WIDTH = 3.6  # inches, beside the names
NAME_WIDTH = 1.5
BAR_HEIGHT = 0.17
LEGEND_COLUMNS = 5


def grid_of_panels(count, bars):
    """A figure with `count` axes, each with room for `bars` bars that share their names."""
    columns = min(count, PANELS_ABREAST)
    rows = math.ceil(count / columns)
    size = (NAME_WIDTH + PANEL_WIDTH * columns, 0.7 + rows * (0.75 + BAR_HEIGHT * bars))
    figure, axes = plt.subplots(rows, columns, figsize=size, sharey=True, squeeze=False)
    for unused in axes.flat[count:]:
        unused.set_visible(False)
    return figure, axes.flat[:count]


def draw_bars(axes, records, structures, key, label):
    """A horizontal bar for each structure, with whiskers where records have a least and a largest."""
    by_structure = {r["structure"]: r for r in records}
    style = styles(structures)
    present = [s for s in structures if s in by_structure and by_structure[s][key] is not None]
    shown = [by_structure[s] for s in present]
    axes.barh(
        [structures.index(s) for s in present],
        [r[key] for r in shown],
        xerr=whiskers(shown, key) if all(key + "_min" in r for r in shown) else None,
        color=[style[s]["color"] for s in present],
        alpha=0.85,
        height=0.75,
        error_kw={"elinewidth": 0.8, "capsize": 1.8},
    )
    for index, s in enumerate(structures):  # the figures stand to the right of the panel, free of whiskers
        text = f"{by_structure[s][key]:.2f}" if s in present else "-"
        axes.annotate(text, (1.01, index), xycoords=("axes fraction", "data"), va="center", fontsize=6)
    axes.axvline(1, color="black", linewidth=0.8)
    axes.set_yticks(range(len(structures)), structures)
    axes.set_ylim(len(structures) - 0.4, -0.6)  # the first on top
    axes.set_xlim(left=0)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(label)


def names(records):
    return distinct(r["structure"] for r in records)


def draw_scenes(records, key, title, label, text=""):
    """A panel of bars for each scene."""
    structures = names(records)
    scenes = distinct(r["scene"] for r in records)
    figure, panels = grid_of_panels(len(scenes), len(structures))
    for axes, scene in zip(panels, scenes):
        draw_bars(axes, [r for r in records if r["scene"] == scene], structures, key, label)
        axes.set_title(scene)
    finish(figure, records, title, text)
    return figure


def draw_speed(records):
    """Records of kind "speed" of one kind of rays and one thread count: the ratio to the reference in each scene."""
    first = records[0]
    title = f'Speed, {first["rays"]} rays, {first["threads"]} threads: longer is faster'
    text = f'bars: median of {first["repeats"]} repeats; whiskers: least and largest; {first["ray_count"]} rays'
    return draw_scenes(records, "ratio_to_embree", title, f"rays per second, times {REFERENCE}", text)


def with_ratio(records, key):
    """Records of kind "build" with "ratio": `key`, with its spread if it has one, over the reference's."""
    reference = {r["scene"]: r[key] for r in records if r["structure"] == REFERENCE}
    found = []
    for r in records:
        if not reference.get(r["scene"]):
            continue
        ratios = {"ratio" + end: r[key + end] / reference[r["scene"]] for end in ("", "_min", "_max") if key + end in r}
        found.append({**r, **ratios})
    return found


def draw_bytes(records, key="structure_bytes", what="Bytes of the structure"):
    """Records of kind "build": bytes over the reference's in each scene."""
    return draw_scenes(with_ratio(records, key), "ratio", f"{what}: shorter is smaller", f"bytes, times {REFERENCE}")


def draw_build_time(records):
    """Records of kind "build": build time over the reference's in each scene."""
    title = f'Build time, {records[0]["threads"]} threads: shorter is faster'
    text = "bars: median of the builds; whiskers: least and largest, where it was built more than once"
    return draw_scenes(with_ratio(records, "build_s"), "ratio", title, f"seconds, times {REFERENCE}'s median", text)


def draw_summary(records):
    """Records of kind "summary" of speed against one reference with one thread count: all scenes."""
    structures = names(records)
    kinds = distinct(r["rays"] for r in records)
    figure, panels = grid_of_panels(len(kinds), len(structures))
    reference = records[0]["reference"]
    for axes, rays in zip(panels, kinds):
        shown = [r for r in records if r["rays"] == rays]
        draw_bars(axes, shown, structures, "mean_ratio", f"rays per second, times {reference}")
        axes.plot([r["worst_ratio"] for r in shown], [structures.index(r["structure"]) for r in shown], "kd",
                  markersize=3)
        axes.set_title(rays.replace("+", " + "))
    title = f'Speed over {max(r["scenes"] for r in records)} scenes, {records[0]["threads"]} threads: longer is faster'
    finish(figure, records, title,
           "bars: geometric mean over the scenes; whiskers: its least and largest in a repeat; diamonds: the "
           "scene where the structure is slowest against " + reference)
    return figure


def varied(record):
    """What the run varied; tolerances are handed over as powers of ten."""
    return 10.0 ** -record["value"] if record["over"] == "tolerance" else record["value"]


def draw_line(axes, records, structure, style, value, spread=None):
    """value(record) of a structure against what the run varied, with whiskers of `spread` if that is a key."""
    shown = sorted((r for r in records if r["structure"] == structure and value(r) is not None),
                   key=lambda r: r["value"])
    if shown:
        axes.errorbar([varied(r) for r in shown], [value(r) for r in shown],
                      yerr=whiskers(shown, spread) if spread else None, label=structure, linewidth=1, markersize=3.5,
                      elinewidth=0.6, capsize=1.5, **style)


def per_triangle(key, factor=1):
    return lambda r: factor * r[key] / r["triangles"]


def scaling_panels(records):
    """What is drawn over the values: label, value of a record, key of its spread, whether in a log scale."""
    over = records[0]["over"]
    if over == "triangles":
        panels = [("build time, ns per triangle", per_triangle("build_s", 1e9), None, False),
                  ("structure, bytes per triangle", per_triangle("structure_bytes"), None, False),
                  ("peak while building, bytes per triangle", per_triangle("peak_bytes"), None, False)]
    else:
        panels = [("build time, s", lambda r: r["build_s"], "build_s", over in ("steps", "tolerance"))]
        if over in ("steps", "tolerance"):
            panels.insert(0, ("structure, MB (1e6 bytes)", lambda r: r["structure_bytes"] / 1e6, None, True))
    ending = "_mrays_per_s"
    for key in distinct(k for r in records for k in r if k.endswith(ending)):
        label = f"{key[:-len(ending)]} rays, million per second"
        panels.append((label, lambda r, key=key: r.get(key), key, False))
    return panels


def legend_height_of(structures):
    """Inches that draw_legend() takes."""
    return 0.1 + 0.15 * math.ceil(len(structures) / LEGEND_COLUMNS)


def draw_legend(figure, panels):
    """One for all panels, which have the same lines, below them."""
    handles, labels = panels.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=LEGEND_COLUMNS, fontsize=7, frameon=False,
                  bbox_to_anchor=(0.5, 0.3 / figure.get_figheight()))


def draw_scaling(records):
    """Records of kind "scaling" of one scene over one thing."""
    over = records[0]["over"]
    structures = names(records)
    style = styles(structures)
    panels = scaling_panels(records)
    columns = 2 if len(panels) == 4 else len(panels)
    rows = math.ceil(len(panels) / columns)
    legend_height = legend_height_of(structures)
    size = (3.7 * columns, 3.0 * rows + 0.6 + legend_height)
    figure, axes_grid = plt.subplots(rows, columns, figsize=size, squeeze=False)
    values = sorted({varied(r) for r in records})
    labels = {"steps": "steps of each moving mesh", "tolerance": "tolerance, of the diagonal"}
    for axes, (label, value, spread, is_log) in zip(axes_grid.flat, panels):
        for structure in structures:
            draw_line(axes, records, structure, style[structure], value, spread)
        if over != "threads":
            axes.set_xscale("log")
        axes.set_xticks(values, [f"{v:g}" if v < 1e4 else f"{v / 1e6:g} M" for v in values])
        axes.minorticks_off()
        if is_log:
            log_scale(axes)
        else:
            axes.set_ylim(bottom=0)
        axes.set_xlabel(labels.get(over, over))
        axes.set_ylabel(label)
    draw_legend(figure, axes_grid)
    finish(figure, records, f'{records[0]["scene"]}: scaling over {over}',
           "points: median; whiskers: least and largest of speed and of build time", legend_height)
    return figure


def draw_budgets(records):
    """Records of kind "scaling" of one scene over bytes: speed against the bytes that structures really take."""
    structures = names(records)
    style = styles(structures)
    ending = "_ratio_to_embree"
    kinds = [k[:-len(ending)] for k in distinct(k for r in records for k in r if k.endswith(ending))]
    reference = next(r["structure_bytes"] for r in records if r["structure"] == REFERENCE)
    legend_height = legend_height_of(structures)
    size = (4.6 * len(kinds), 3.4 + 0.6 + legend_height)
    figure, panels = plt.subplots(1, len(kinds), figsize=size, squeeze=False)
    for axes, kind in zip(panels.flat, kinds):
        for structure in structures:
            points = sorted({(r["structure_bytes"] / reference, r[kind + ending]) for r in records
                             if r["structure"] == structure})
            if structure == REFERENCE:
                points = [(1.0, 1.0)]
            axes.plot([x for x, _ in points], [y for _, y in points], label=structure, linewidth=1, markersize=3.5,
                      **style[structure])
        axes.set_xlim(left=0)
        axes.set_ylim(bottom=0)
        axes.grid(linewidth=0.3)
        axes.set_xlabel(f"bytes, times {REFERENCE}")
        axes.set_ylabel(f"{kind} rays per second, times {REFERENCE}")
    draw_legend(figure, panels)
    finish(figure, records, f'{records[0]["scene"]}: what memory buys',
           "a point for each limit of bytes; beyond what rays profit from, no more is taken", legend_height)
    return figure


def draw_edits(records):
    """Records of kind "edit" of one scene: what each commit took, and how fast rays are after it."""
    structures = names(records)
    style = styles(structures)
    legend_height = legend_height_of(structures)
    figure, panels = plt.subplots(1, 2, figsize=(10, 3.6 + legend_height), squeeze=False)
    commits, speeds = panels.flat
    for structure in structures:
        shown = sorted((r for r in records if r["structure"] == structure), key=lambda r: r["edit"])
        commits.plot([r["edit"] for r in shown], [1e3 * r["commit_s"] for r in shown], label=structure, linewidth=0.6,
                     markersize=2.5, **style[structure])
        anew = [r for r in shown if r["rebuild_s"] > 0]
        commits.plot([r["edit"] for r in anew], [1e3 * r["rebuild_s"] for r in anew], linewidth=0.8, linestyle=":",
                     color=style[structure]["color"])
        traced = [r for r in shown if "speed_to_rebuilt" in r]
        speeds.errorbar([r["edit"] for r in traced], [r["speed_to_rebuilt"] for r in traced],
                        yerr=whiskers(traced, "speed_to_rebuilt"), linewidth=0.8, markersize=3, elinewidth=0.6,
                        capsize=1.5, **style[structure])
    log_scale(commits)
    commits.set_ylabel("commit, ms")
    speeds.axhline(1, color="black", linewidth=0.5)
    speeds.set_ylim(bottom=0)
    speeds.set_ylabel("rays per second, times built anew")
    for axes in panels.flat:
        axes.set_xlabel("edit")
        axes.grid(linewidth=0.3)
    draw_legend(figure, panels)
    finish(figure, records, f'{records[0]["scene"]}: what changes cost',
           "dotted: the structure built anew; whiskers: least and largest of the repeats", legend_height)
    return figure


def draw_frames(records):
    """Records of kind "frames" of one scene: what a frame costs, by its rays."""
    counts = distinct(r["frames"] for r in records)
    structures = names(records)
    style = styles(structures)
    legend_height = legend_height_of(structures)
    figure, panels = plt.subplots(1, len(counts), figsize=(4.8 * len(counts), 3.6 + legend_height), squeeze=False)
    rays = [10 ** (4 + 0.25 * i) for i in range(21)]
    for axes, frames in zip(panels.flat, counts):
        for r in (r for r in records if r["frames"] == frames):
            colour = style[r["structure"]]["color"]
            one = [r["build_s"] / frames + n / (1e6 * r["mrays_per_s"]) for n in rays]
            each = [r["frame_build_s"] + n / (1e6 * r["frame_mrays_per_s"]) for n in rays]
            axes.plot(rays, one, color=colour, label=r["structure"], linewidth=1)
            axes.plot(rays, each, color=colour, linestyle=":", linewidth=1)
            if rays[0] < r["crossover_rays"] < rays[-1]:
                n = r["crossover_rays"]
                axes.plot([n], [r["build_s"] / frames + n / (1e6 * r["mrays_per_s"])], "o", color=colour, markersize=4)
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
        log_scale(axes)
        axes.set_title(f"{frames} frames")
        axes.set_xlabel("rays of a frame")
        axes.set_ylabel("seconds for a frame, building and tracing")
    draw_legend(figure, panels)
    finish(figure, records, f'{records[0]["scene"]}: one structure for all frames, or one for each',
           "lines: one for all; dotted: one for each; circles: from here on one for each is cheaper", legend_height)
    return figure


def draw_truth(records):
    """Records of kind "truth": RMSE against the samples, beside the line of pure noise."""
    shown = sorted(records, key=lambda r: r["samples_per_pixel"])
    samples = [r["samples_per_pixel"] for r in shown]
    figure, axes = plt.subplots(figsize=(6.4, 3.4))
    axes.loglog(samples, [r["rmse"] for r in shown], "o-", color="#d55e00", label=shown[0]["structure"])
    axes.loglog(samples, [shown[0]["rmse"] * (samples[0] / n) ** 0.5 for n in samples], ":", color="black",
                linewidth=0.8, label="one over the root of the samples")
    log_scale(axes)
    axes.set_xticks(samples, samples)
    axes.minorticks_off()
    axes.set_xlabel("samples per pixel")
    axes.set_ylabel("RMSE")
    axes.legend(frameon=False)
    finish(figure, records, f'{shown[0]["scene"]}: motion against the mean of {shown[0]["frozen_times"]} frozen times',
           f'reference through {shown[0]["reference_structure"]}, a sample of each pixel for each time')
    return figure


def charts(records):
    """File names, without ending, and what draws them. Records of a gallery are drawn as such alone."""
    if any(r["kind"] == "gallery" for r in records):
        yield from gallery_charts.charts(records)
        return
    kinds = {kind: [r for r in records if r["kind"] == kind] for kind in KINDS}
    summaries = [r for r in kinds["summary"] if r["measure"] == "speed"]
    for (reference, threads), group in grouped(summaries, "reference", "threads").items():
        yield f"speed-to-{reference}-{threads}-threads", lambda group=group: draw_summary(group)
    with_reference = [r for r in kinds["speed"] if r["ratio_to_embree"] is not None]
    for (rays, threads), group in grouped(with_reference, "rays", "threads").items():
        yield f"speed-{rays}-{threads}-threads", lambda group=group: draw_speed(group)
    if with_ratio(kinds["build"], "structure_bytes"):
        yield "bytes", lambda: draw_bytes(kinds["build"])
        yield "bytes-with-buffers", lambda: draw_bytes(kinds["build"], "total_bytes", "Bytes with the scene's buffers")
        yield "build-time", lambda: draw_build_time(kinds["build"])
    for (over, scene), group in grouped(kinds["scaling"], "over", "scene").items():
        draw = draw_budgets if over == "bytes" else draw_scaling
        yield f"scaling-{over}-{scene}", lambda group=group, draw=draw: draw(group)
    for (scene,), group in grouped(kinds["edit"], "scene").items():
        yield f"edits-{scene}", lambda group=group: draw_edits(group)
    for (scene,), group in grouped(kinds["frames"], "scene").items():
        yield f"frames-{scene}", lambda group=group: draw_frames(group)
    if kinds["truth"]:
        yield "truth", lambda: draw_truth(kinds["truth"])


def file_name(name):
    """The name of a chart as a file's: scenes may be called anything."""
    return re.sub(r"[^\w.+-]", "_", name)


def select(records, structures):
    """The records of `structures`, in that order. Ends the script for a name that none has."""
    present = names(records)
    for name in structures:
        if name not in present:
            fail(f'There are no records of the structure "{name}" (there are: {", ".join(present)}).')
    return [r for name in structures for r in records if r["structure"] == name]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("records", nargs="+", metavar="RECORDS.json")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="made if it is not there")
    parser.add_argument("--structures", help="names, separated by commas, in the order of the bars; default: all")
    parser.add_argument("--format", choices=("svg", "png"), default="svg")
    arguments = parser.parse_args()
    make_folder(arguments.output)
    records = [r for r in read_records(arguments.records) if r["kind"] in KINDS]
    check_distinct(records)
    if arguments.structures:
        records = select(records, arguments.structures.split(","))
    drawn = 0
    for name, draw in charts(records):
        path = os.path.join(arguments.output, f"{file_name(name)}.{arguments.format}")
        save(draw(), path)
        print(path, flush=True)
        drawn += 1
    if drawn == 0:
        fail("There is nothing to draw: no records of bench with embree among the structures, nor of scaling, edits or frames.")


if __name__ == "__main__":
    run(main)
