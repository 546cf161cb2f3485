"""Charts of the records that `stbvh-ab gallery` writes: the methods before ours and ours without its ideas.

charts() says which file each goes to. The functions that draw take records and return a figure.
"""
import math

from chart_tools import COLOURS, LINES, MARKERS, finish, lighter, log_scale, plt
from record_files import distinct, grouped

DIRECT, SCALAR = "stbvh-direct", "stbvh-direct-scalar"  # what methods are held against
ALL_RAYS = "bounce+uniform+shadow"
WITHOUT = "no-"  # ours without an idea
BAR_HEIGHT = 0.2
SLICE_WIDTH = 1.55  # inches

# What a structure is says its colour.
EARLIER, OURS, ABLATION, EMBREES = COLOURS[0], COLOURS[2], COLOURS[1], COLOURS[3]
KINDS = ((EARLIER, "other methods"), (EMBREES, "made of Embree's"), (OURS, "STBVH"), (ABLATION, "STBVH without an idea"))


def colour_of(structure):
    if structure.startswith(WITHOUT):
        return ABLATION
    if structure.startswith("stbvh"):
        return OURS
    return EMBREES if structure.startswith(("embree", "lbvh")) else EARLIER


def geometric_mean(values):
    values = [v for v in values if v]
    return math.exp(sum(map(math.log, values)) / len(values)) if values else None


def names_of(records):
    return distinct(r["structure"] for r in records if r["kind"] == "gallery")


def compared(records):
    """Whose speed that of each structure is held against."""
    return {r["structure"]: r["compared_with"] for r in records if r["kind"] == "gallery"}


def is_scalar(records, structure):
    return compared(records)[structure] == SCALAR


# --- all methods side by side ---


def summary_of(records, structure, measure, reference, rays=None):
    for r in records:
        if (r["kind"] == "summary" and r["structure"] == structure and r["measure"] == measure
                and r["reference"] == reference and r["rays"] == rays):
            return r
    return None


def joint_rays(records):
    """All incoherent rays together where they were traced, else the first kind."""
    kinds = distinct(r["rays"] for r in records if r["kind"] == "summary" and r["measure"] == "speed")
    return ALL_RAYS if ALL_RAYS in kinds else next(iter(kinds), None)


def speed_bars(records, structures):
    against = compared(records)
    rays = joint_rays(records)
    found = {}
    for s in structures:
        r = summary_of(records, s, "speed", against[s], rays)
        if r:
            found[s] = (r["mean_ratio"], r["mean_ratio"] - r["mean_ratio_min"], r["mean_ratio_max"] - r["mean_ratio"])
    return found


def byte_bars(records, structures):
    found = {s: summary_of(records, s, "structure_bytes", DIRECT) for s in structures}
    return {s: (r["mean_ratio"], 0, 0) for s, r in found.items() if r}


def visit_bars(records, structures, key):
    groups = grouped([r for r in records if r["kind"] == "gallery"], "structure")
    means = {s: geometric_mean(r[key] for r in groups[(s,)]) for s in structures}
    return {s: (mean, 0, 0) for s, mean in means.items() if mean is not None}


def draw_bars(axes, records, structures, bars, left=None, light=0.0):
    """A horizontal bar for each structure; hatched where it has no vector instructions."""
    left = left or {}
    for s, (value, below, above) in bars.items():
        begin = left.get(s, (0, 0, 0))[0]
        error = [[below], [above]] if below or above else None
        axes.barh(structures.index(s), value, left=begin, xerr=error, height=0.72,
                  color=lighter(colour_of(s), 0.15 + light), edgecolor="white", linewidth=0.3,
                  hatch="/////" if is_scalar(records, s) else None, error_kw={"elinewidth": 0.8, "capsize": 1.6})


def write_values(axes, structures, texts):
    """Figures to the right of the panel, free of whiskers."""
    for index, s in enumerate(structures):
        axes.annotate(texts.get(s, "-"), (1.015, index), xycoords=("axes fraction", "data"), va="center", fontsize=6.5)


def finish_bars(axes, structures, label):
    axes.set_yticks(range(len(structures)), structures)
    axes.set_ylim(len(structures) - 0.4, -0.6)  # the first on top
    axes.grid(axis="y", visible=False)
    axes.set_xlim(left=0)
    axes.set_xlabel(label)


def draw_gallery(records):
    """Speed, nodes and leaves, bytes of every structure over all scenes."""
    structures = names_of(records)
    figure, (speed, visits, size) = plt.subplots(1, 3, sharey=True, figsize=(10, 1.7 + BAR_HEIGHT * len(structures)))

    bars = speed_bars(records, structures)
    draw_bars(speed, records, structures, bars)
    speed.axvline(1, color="black", linewidth=0.8)
    write_values(speed, structures, {s: f"{v[0]:.2f}" for s, v in bars.items()})
    finish_bars(speed, structures, f"speed, times {DIRECT}\n(hatched: times {SCALAR})")

    nodes, leaves = (visit_bars(records, structures, key) for key in ("nodes_per_ray", "leaves_per_ray"))
    draw_bars(visits, records, structures, nodes)
    draw_bars(visits, records, structures, leaves, nodes, 0.45)
    write_values(visits, structures, {s: f"{nodes[s][0]:.1f} + {leaves[s][0]:.1f}" for s in nodes if s in leaves})
    finish_bars(visits, structures, "nodes (dark) + leaves (light)\nof a bounce or uniform ray")

    bars = byte_bars(records, structures)
    draw_bars(size, records, structures, bars)
    size.axvline(1, color="black", linewidth=0.8)
    write_values(size, structures, {s: f"{v[0]:.2f}" for s, v in bars.items()})
    finish_bars(size, structures, f"bytes, times {DIRECT}\n(logarithmic)" if wide(bars) else f"bytes, times {DIRECT}")
    if wide(bars):
        size.set_xscale("log")
        values = [v[0] for v in bars.values()]
        size.set_xlim(left=0.7 * min(values))
        size.set_xticks([2.0**k for k in range(-10, 11) if 0.7 * min(values) < 2.0**k < 1.1 * max(values)])
        size.minorticks_off()
        size.xaxis.set_major_formatter("{x:g}")

    shown = {colour_of(s) for s in structures}
    figure.legend([plt.Rectangle((0, 0), 1, 1, color=lighter(colour, 0.15)) for colour, _ in KINDS if colour in shown]
                  + [plt.Rectangle((0, 0), 1, 1, facecolor="0.6", edgecolor="white", hatch="/////")],
                  [text for colour, text in KINDS if colour in shown] + ["without vector instructions"],
                  loc="lower center", ncol=5, fontsize=7.5, frameon=False, bbox_to_anchor=(0.5, 0.3 / figure.get_figheight()))
    scenes = len(distinct(r["scene"] for r in records if r["kind"] == "gallery"))
    rays = (joint_rays(records) or "no").replace("+", ", ")
    finish(figure, records, f"The gallery over {scenes} scene{'s' if scenes > 1 else ''}",
           f"geometric means; speed: {rays} rays, whiskers: least and largest mean in a repeat", legend_height=0.3)
    figure.subplots_adjust(wspace=0.34)
    return figure


def wide(bars):
    values = [v[0] for v in bars.values()]
    return bool(values) and max(values) > 12 * min(values)


# --- growth ---


def line_styles(structures):
    """Lines that are told apart; ours is the thick one."""
    others = [c for c in COLOURS if c != OURS]
    found = {}
    for index, structure in enumerate(s for s in structures if s != DIRECT):
        found[structure] = {"color": others[index % len(others)], "marker": MARKERS[index % len(MARKERS)],
                            "linestyle": LINES[index // len(others) % len(LINES)], "linewidth": 1}
    found[DIRECT] = {"color": OURS, "marker": "o", "linestyle": "-", "linewidth": 2}
    return found


def relative_speed(records, structure, reference, value):
    """Geometric mean over the kinds of rays at one value, by way of Embree."""
    at = {r["structure"]: r for r in records if r["value"] == value}
    mine, other = at.get(structure), at.get(reference)
    if mine is None or other is None:
        return None
    keys = [k for k in mine if k.endswith("_ratio_to_embree") and k in other]
    return geometric_mean([mine[k] / other[k] for k in keys]) if keys else None


def growth_names(records):
    """Those whose lines are drawn: of the separate trees one, of ours without an idea none."""
    separate = [s for s in names_of(records) if s.startswith("separate-")]
    left_out = set(separate[:len(separate) // 2] + separate[len(separate) // 2 + 1:]) | {"embree", SCALAR}
    return [s for s in names_of(records) if s not in left_out and not s.startswith(WITHOUT)]


def draw_growth(records, growing):
    """Records of kind "scaling" over one thing: speed, bytes, build time of each method."""
    over = growing[0]["over"]
    present = {r["structure"] for r in growing}
    structures = [s for s in growth_names(records) if s in present]
    style = line_styles(structures)
    against = compared(records)
    values = sorted({r["value"] for r in growing})
    scale = 0.25 if over == "quarter turns" else 1
    legend_height = 0.1 + 0.16 * math.ceil(len(structures) / 4)
    figure, panels = plt.subplots(1, 3, figsize=(11, 3.5 + legend_height))
    for structure in structures:
        own = {r["value"]: r for r in growing if r["structure"] == structure}
        x = [scale * v for v in values if v in own]
        lines = ([relative_speed(growing, structure, against[structure], v) for v in values if v in own],
                 [own[v]["structure_bytes"] / 1e6 for v in values if v in own],
                 [own[v]["build_s"] for v in values if v in own])
        for axes, y in zip(panels, lines):
            shown = [(a, b) for a, b in zip(x, y) if b is not None]
            axes.plot([a for a, _ in shown], [b for _, b in shown], label=structure, markersize=3.5,
                      **style[structure])
    for axes, label in zip(panels, (f"speed, times {DIRECT}", "MB (1e6 bytes)", "build time, s")):
        if over == "steps":
            axes.set_xscale("log")
            axes.set_xticks(values, [f"{v:g}" for v in values])
        else:
            axes.set_xticks([scale * v for v in values if v % 2 == 0])
        axes.minorticks_off()
        axes.set_xlabel("steps" if over == "steps" else "turns while the shutter is open")
        axes.set_ylabel(label)
    panels[0].set_ylim(bottom=0)
    for axes in panels[1:]:
        log_scale(axes)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=4, fontsize=7.5, frameon=False,
                  bbox_to_anchor=(0.5, 0.3 / figure.get_figheight()))
    what = "steps" if over == "steps" else "the curvature of the motion"
    finish(figure, growing, f'How the methods grow with {what}: {growing[0]["scene"]}, {growing[0]["triangles"]:,} triangles',
           f"speed: bounce and uniform rays, geometric mean; of methods without vector instructions times {SCALAR}",
           legend_height)
    return figure


def separate_errors(records):
    """Share of answers that are wrong by the number of trees, for each scene."""
    found = {}
    for r in records:
        if r["kind"] == "gallery" and r["structure"].startswith("separate-") and r["traced"] > 0:
            trees = int(r["structure"].split("-")[1])
            found.setdefault(r["scene"], []).append((trees, r["wrong"] / r["traced"]))
    return found


def draw_separate(records):
    """The price of answering for the wrong time."""
    figure, axes = plt.subplots(figsize=(6.4, 3.6))
    lines = separate_errors(records)
    for index, (scene, points) in enumerate(lines.items()):
        points.sort()
        axes.plot([n for n, _ in points], [100 * share for _, share in points], label=scene, linewidth=1.1, markersize=4,
                  color=COLOURS[index % len(COLOURS)], marker=MARKERS[index % len(MARKERS)])
    trees = sorted({n for points in lines.values() for n, _ in points})
    axes.set_xscale("log", base=2)
    axes.set_xticks(trees, trees)
    axes.minorticks_off()
    axes.set_ylim(bottom=0)
    axes.set_xlabel("static trees in the shutter")
    axes.set_ylabel("rays answered wrongly, %")
    axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    finish(figure, [r for r in records if r["kind"] == "gallery"], "Separate trees: the error of time",
           "answers that differ from the exact oracle beyond rounding, all kinds of rays")
    return figure


# --- time slices ---


def hull(points):
    """Corners of the convex hull, counter-clockwise."""
    points = sorted({(x, y) for x, y in points})
    if len(points) < 3:
        return points

    def half(sequence):
        chain = []
        for p in sequence:
            while len(chain) > 1 and cross(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(points) + half(reversed(points))


def cross(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def area(polygon):
    return 0.5 * abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(polygon, polygon[1:] + polygon[:1])))


def draw_slice(axes, triangles, bounds, colour):
    for shape in bounds:
        corners = hull(shape)
        if len(corners) > 2:
            axes.fill(*zip(*corners), facecolor=(*lighter(colour, 0), 0.1), edgecolor=(*lighter(colour, 0), 0.9), linewidth=0.6)
    for shape in triangles:
        axes.fill(*zip(*shape), facecolor="0.25", edgecolor="0.55", linewidth=0.2, zorder=3)


def draw_slices(records, slices, structures, title):
    """Bounds of each structure at each time over the triangles: a row for each structure."""
    times = sorted({r["time"] for r in slices})
    by_key = {(r["structure"], r["time"]): r["shapes"] for r in slices}
    figure, panels = plt.subplots(len(structures), len(times), squeeze=False,
                                  figsize=(1.5 + SLICE_WIDTH * len(times), 0.8 + SLICE_WIDTH * len(structures)))
    reach = 1.02 * max(abs(c) for shapes in by_key.values() for shape in shapes for p in shape for c in p)
    for row, structure in zip(panels, structures):
        for axes, time in zip(row, times):
            triangles, bounds = by_key[None, time], by_key.get((structure, time), [])
            draw_slice(axes, triangles, bounds, colour_of(structure))
            axes.set_xlim(-reach, reach)
            axes.set_ylim(-reach, reach)
            axes.set_aspect("equal")
            axes.grid(False)
            axes.set_xticks([])
            axes.set_yticks([])
            axes.spines[:].set_color("0.8")
            covered = sum(area(hull(shape)) for shape in bounds) / area(hull([p for shape in triangles for p in shape]))
            axes.set_xlabel(f"{len(bounds)} bounds, area {covered:.1f}", fontsize=7, labelpad=2)
        row[0].set_ylabel(structure, rotation=0, ha="right", va="center", labelpad=8, fontsize=9)
    for axes, time in zip(panels[0], times):
        axes.set_title(f"time {time:.2f}")
    finish(figure, slices, title,
           "a bar that turns by half a turn in 8 segments; shapes: bounds of the leaves that rays of that time are held against; "
           "area: their sum, the bar's is 1")
    return figure


def slice_groups(records, slices):
    """The methods, then ours without its ideas, as far as they can be shown."""
    shown = distinct(r["structure"] for r in slices if r["structure"] is not None)
    separate = [s for s in shown if s.startswith("separate-")]
    methods = [s for s in shown if not s.startswith((WITHOUT, "separate-")) or s in separate[len(separate) // 2:][:1]]
    methods = [s for s in methods if s != SCALAR]
    without = [s for s in shown if s.startswith(WITHOUT)]
    if methods:
        yield "gallery-slices", methods, "What each method sees at a time"
    if without:
        yield "gallery-slices-ours", without + [s for s in shown if s == DIRECT], "What is seen without each of our ideas"


def charts(records):
    """File names, without ending, and what draws them."""
    if any(r["kind"] == "summary" for r in records):
        yield "gallery", lambda: draw_gallery(records)
    for (over,), group in grouped([r for r in records if r["kind"] == "scaling"], "over").items():
        yield f"gallery-{over.replace(' ', '-')}", lambda group=group: draw_growth(records, group)
    if separate_errors(records):
        yield "gallery-separate", lambda: draw_separate(records)
    slices = [r for r in records if r["kind"] == "slice"]
    for name, structures, title in slice_groups(records, slices):
        yield name, lambda structures=structures, title=title: draw_slices(records, slices, structures, title)
