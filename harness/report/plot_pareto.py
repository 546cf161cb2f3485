#!/usr/bin/env python3
"""Speed against error, one point for each structure: plot_pareto.py RECORDS.json PICTURE.png

Reads the records of kind "pareto" that `stbvh-ab pareto` writes. A rate of zero is drawn at its bound
(95 %) with an arrow: less than that.
"""
import json
import sys

import matplotlib
import matplotlib.ticker

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

PANELS = (
    ("leak_rate", "leaks, of rays aimed at vertices and edges\nof closed moving meshes"),
    ("differing_rate", "answered otherwise than exactly,\nof rays at needles and slivers"),
    ("t_error_rel_p99", "error of t, relative, 99th percentile,\n$10^6$ from the origin"),
)
COLOURS = {"embree": "#4878a8", "lbvh": "#999999", "stbvh": "#d1622b"}


def draw_panel(axes, records, key):
    for index, record in enumerate(records):
        colour = COLOURS[record["structure"].split("-")[0]]
        filled = "direct" not in record["structure"]
        value = record[key]
        is_zero = value == 0
        if is_zero:
            value = record[key + "_bound_95"]
        speed = record["ratio_to_embree"]
        axes.errorbar(
            speed,
            value,
            xerr=[[speed - record["ratio_to_embree_min"]], [record["ratio_to_embree_max"] - speed]],
            fmt="o",
            color=colour,
            markerfacecolor=colour if filled else "white",
            elinewidth=0.6,
            capsize=1.5,
            uplims=is_zero,
            yerr=value * 0.5 if is_zero else None,
        )
        axes.annotate(
            record["structure"],
            (speed, value),
            textcoords="offset points",
            xytext=(0, 6 + 9 * (index % 3)),
            ha="center",
            fontsize=6.5,
            color=colour,
        )
    axes.set_yscale("log")
    axes.margins(x=0.12, y=0.2)
    bottom, top = axes.get_ylim()
    axes.set_ylim(min(bottom, top / 30), top)
    axes.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.set_xlabel("speed, times embree")
    axes.grid(True, which="major", linewidth=0.3)


def main(records_path, picture_path):
    with open(records_path, encoding="utf-8") as file:
        report = json.load(file)
    records = [r for r in report["records"] if r["kind"] == "pareto"]
    if not records:
        sys.exit(f'There are no records of kind "pareto" in "{records_path}".')
    figure, all_axes = plt.subplots(1, len(PANELS), figsize=(13, 4.6))
    for axes, (key, title) in zip(all_axes, PANELS):
        draw_panel(axes, records, key)
        axes.set_title(title, fontsize=9)
    machine = report["machine"]
    figure.suptitle("Speed against error: right is faster, down is more exact", fontsize=11)
    figure.text(
        0.01,
        0.01,
        f'{machine["cpu"]}, Embree {machine["embree"]}, stbvh {report["commit"]}; arrows: none found, '
        "below the bound of 95 % confidence; open circles: kernels without Embree",
        fontsize=6,
    )
    figure.tight_layout(rect=(0, 0.03, 1, 0.97))
    figure.savefig(picture_path, dpi=150)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: plot_pareto.py RECORDS.json PICTURE.png")
    main(sys.argv[1], sys.argv[2])
