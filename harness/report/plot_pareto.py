#!/usr/bin/env python3
"""Speed against error, one point for each structure: plot_pareto.py RECORDS.json PICTURE.png

Reads the records of kind "pareto" that `stbvh-ab pareto` writes. A rate of zero is drawn at its bound
(95 %) with an arrow: less than that.
"""
import sys

from chart_tools import COLOURS, family, finish, log_scale, plt, save
from matplotlib.ticker import NullFormatter
from record_files import fail, read_records, run

PANELS = (
    ("leak_rate", "leaks, of rays aimed at vertices and edges\nof closed moving meshes"),
    ("differing_rate", "answered otherwise than exactly,\nof rays at needles and slivers"),
    ("t_error_rel_p99", "error of t, relative, 99th percentile,\n10⁶ from the origin"),
)
MARKERS = {"robust": "s", "4v": "^", "fast": "v"}


def draw_panel(axes, records, key):
    families = list(dict.fromkeys(family(r["structure"]) for r in records))
    for record in records:
        name = record["structure"]
        colour = COLOURS[families.index(family(name)) % len(COLOURS)]
        value = record[key]
        is_zero = value == 0
        if is_zero:
            value = record[key + "_bound_95"]
        speed = record["ratio_to_embree"]
        axes.errorbar(
            speed,
            value,
            xerr=[[speed - record["ratio_to_embree_min"]], [record["ratio_to_embree_max"] - speed]],
            fmt=MARKERS.get(name.split("-")[-1], "o"),
            color=colour,
            markerfacecolor="white" if "direct" in name else colour,
            elinewidth=0.5,
            capsize=1.5,
            uplims=is_zero,
            yerr=value * 0.5 if is_zero else None,
            label=name,
        )
    values = [r[key] or r[key + "_bound_95"] for r in records]
    axes.margins(x=0.06, y=0.12)
    if max(values) > 10 * min(values):
        log_scale(axes)
        axes.yaxis.set_minor_formatter(NullFormatter())
    else:
        axes.set_ylim(0, 1.25 * max(values))
    axes.set_xlabel("speed, times embree")
    axes.grid(True, which="major", linewidth=0.3)


def draw_pareto(records):
    """Records of kind "pareto": a panel for each measure of error."""
    figure, all_axes = plt.subplots(1, len(PANELS), figsize=(13, 4.6))
    for axes, (key, title) in zip(all_axes, PANELS):
        draw_panel(axes, records, key)
        axes.set_title(title, fontsize=9)
    handles, names = all_axes[0].get_legend_handles_labels()
    figure.legend(
        [handle[0] for handle in handles], names, loc="lower center", ncol=len(names), fontsize=8, frameon=False,
        bbox_to_anchor=(0.5, 0.05),
    )
    finish(figure, records, "Speed against error: right is faster, down is more exact",
           "arrows: none found, below the bound of 95 % confidence; open circles: kernels without Embree",
           legend_height=0.2)
    return figure


def main(records_path, picture_path):
    # Of structures that no scene compares with embree there is no speed.
    records = [r for r in read_records([records_path]) if r["kind"] == "pareto" and r["ratio_to_embree"] > 0]
    if not records:
        fail(f'There are no records of kind "pareto" with speeds in "{records_path}".')
    save(draw_pareto(records), picture_path)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: plot_pareto.py RECORDS.json PICTURE.png")
    run(lambda: main(sys.argv[1], sys.argv[2]))
