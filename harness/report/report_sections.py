"""From records to the sections of a report. Each function takes the records of its part and returns a section."""
from statistics import geometric_mean

from page_blocks import Card, Cards, Cell, Chart, Commands, Fold, Picture, Pictures, Section, Table, Text
from record_files import distinct, grouped

REFERENCE = "embree"
IMAGES = "images/"  # where the pictures are that records name
MAIN = "stbvh"  # what the first figures are about, where it was compared
WRONG = (("missed", "missed"), ("false_hits", "false hits"), ("wrong_primitive", "wrong triangle"))


def is_ours(structure):
    return structure.startswith("stbvh")


def ours_among(names):
    return {index for index, name in enumerate(names) if is_ours(name)}


def spread(record, key):
    return f'{record[key + "_min"]:.2f} to {record[key + "_max"]:.2f}'


def number(value):
    return f"{value:,}"


def bad_count(count, n):
    """A count out of n; none says what that proves: less than 3 / n with 95 % confidence."""
    if n == 0:
        return Cell("-")
    return Cell(number(count), "bad") if count else Cell("0", "good")


def main_structure(names):
    return next((n for n in [MAIN] + [n for n in names if is_ours(n)] if n in names), names[0] if names else MAIN)


def times(value):
    return f"{value:.2f}×" if value > 0 else "-"


# --- summary ---


def speed_summaries(records, reference):
    """Of all kinds of rays together where there is such a record, with the most threads."""
    found = [r for r in records if r["kind"] == "summary" and r["measure"] == "speed" and r["reference"] == reference]
    threads = max((r["threads"] for r in found), default=0)
    return [r for r in found if r["threads"] == threads]


def together(summaries):
    """The widest joint of kinds of rays among summaries."""
    kinds = distinct(r["rays"] for r in summaries)
    return max(kinds, key=lambda k: k.count("+")) if kinds else None


def in_words(rays):
    return rays.replace("+", ", ") + " rays" + (" together" if "+" in rays else "")


def speed_cards(records, structure):
    for reference in (REFERENCE, "embree-4v", "lbvh"):
        summaries = speed_summaries(records, reference)
        joint = together(summaries)
        for r in summaries:
            if r["structure"] == structure and r["rays"] == joint and structure != reference:
                yield Card(times(r["mean_ratio"]), f"the speed of `{reference}`",
                           f'{spread(r, "mean_ratio")} in a repeat; {in_words(joint)}, {r["scenes"]} scenes, '
                           f'{r["threads"]} threads. Worst: {times(r["worst_ratio"])} in {r["worst_scene"]}')


def build_cards(records, structure):
    words = {"structure_bytes": ("the bytes", "of the structure, geometric mean"),
             "build_s": ("the build time", "geometric mean")}
    for r in records:
        if (r["kind"] == "summary" and r["structure"] == structure and r["reference"] == REFERENCE
                and r["measure"] in words):
            what, detail = words[r["measure"]]
            yield Card(times(r["mean_ratio"]), f"{what} of `{REFERENCE}`",
                       f'{detail} of {r["scenes"]} scenes. Most: {times(r["worst_ratio"])} in {r["worst_scene"]}')


def error_card(records, structure):
    found = [r for r in records if r["kind"] == "error" and r["structure"] == structure]
    traced = sum(r["traced"] for r in found)
    wrong = sum(r[key] for r in found for key, _ in WRONG)
    if traced:
        proven = f"; below {3 / traced:.1e} with 95 % confidence" if wrong == 0 else ""
        yield Card(number(wrong), "wrong answers",
                   f"of {number(traced)} rays compared with an exact oracle{proven}")


def summary_table(records):
    summaries = speed_summaries(records, REFERENCE)
    kinds = distinct(r["rays"] for r in summaries)
    joint = together(summaries)
    by_key = {(r["structure"], r["rays"]): r for r in summaries}
    rest = {(r["structure"], r["measure"]): r for r in records
            if r["kind"] == "summary" and r["measure"] in ("structure_bytes", "build_s") and r["reference"] == REFERENCE}
    names = distinct(r["structure"] for r in summaries)
    rows = []
    for name in names:
        shown = [by_key.get((name, k)) for k in kinds]
        cells = [f'{r["mean_ratio"]:.2f}' if r else "-" for r in shown]
        r = by_key.get((name, joint))
        cells.append(spread(r, "mean_ratio") if r else "-")
        cells.append(f'{r["worst_ratio"]:.2f} {r["worst_scene"]}' if r else "-")
        for measure in ("structure_bytes", "build_s"):
            r = rest.get((name, measure))
            cells.append(f'{r["mean_ratio"]:.2f}' if r else "-")
        rows.append([f"`{name}`"] + cells)
    head = ["structure"] + [k.replace("+", " + ") for k in kinds] + ["least to largest", "worst scene", "bytes", "build time"]
    return Table(head, rows, f"Ratios to `{REFERENCE}` on the same rays in the same run: speed (more is faster), bytes and "
                 "build time (less is better). Geometric means over the scenes; least to largest: of the mean in a "
                 f"repeat, {joint.replace('+', ' + ')}.", ours_among(names))


def summary(records, structures):
    main = main_structure(structures)
    cards = list(speed_cards(records, main)) + list(build_cards(records, main)) + list(error_card(records, main))
    blocks = [Text(f"`{main}` is a spatial-temporal BVH for multi-segment motion blur, a user geometry of Embree. Here it "
                   "is compared with Embree's own motion-blur trees and with one linear-motion BVH for each time segment "
                   "(`lbvh`), on the same rays.")]
    if cards:
        blocks.append(Cards(cards))
    if speed_summaries(records, REFERENCE):
        blocks.append(summary_table(records))
    return Section("summary", "Summary", blocks)


# --- speed, memory, build time ---


def speed_table(records):
    """Of one thread count."""
    names = distinct(r["structure"] for r in records)
    kinds = distinct(r["rays"] for r in records)
    by_key = {(r["scene"], r["structure"], r["rays"]): r for r in records}
    rows, strong = [], set()
    for scene in distinct(r["scene"] for r in records):
        for name in names:
            cells = []
            for rays in kinds:
                r = by_key.get((scene, name, rays))
                ratio = f' ({r["ratio_to_embree"]:.2f})' if r and r["ratio_to_embree"] is not None else ""
                cells.append(f'{r["mrays_per_s"]:.2f}{ratio}' if r else "-")
            if is_ours(name):
                strong.add(len(rows))
            rows.append([f"{scene} `{name}`"] + cells)
    return Table(["scene, structure"] + kinds, rows,
                 f"Million rays per second, and the ratio to `{REFERENCE}`; medians of {records[0]['repeats']} repeats.", strong)


def speed(records, charts):
    speeds = [r for r in records if r["kind"] == "speed"]
    first = f'speed-to-{REFERENCE}-{max(r["threads"] for r in speeds)}-threads'
    blocks = [charts[n] for n in charts if n == first]
    others = [charts[n] for n in charts if n.startswith("speed-") and n != first]
    if others:
        blocks.append(Fold("Charts of each kind of rays, and against the other references", others))
    for (threads,), group in grouped(speeds, "threads").items():
        blocks.append(Fold(f"Every scene with {threads} thread{'s' if threads > 1 else ''}", [speed_table(group)]))
    return Section("speed", "Speed", blocks)


def build_table(records):
    reference = {r["scene"]: r for r in records if r["structure"] == REFERENCE}
    rows, strong = [], set()
    for r in records:
        against = reference.get(r["scene"])
        ratio = lambda key: f"{r[key] / against[key]:.2f}" if against and against[key] else "-"  # noqa: E731
        if is_ours(r["structure"]):
            strong.add(len(rows))
        rows.append([f'{r["scene"]} `{r["structure"]}`', number(r["triangles"]), f'{r["structure_bytes"] / 1e6:.1f}',
                     ratio("structure_bytes"), f'{r["total_bytes"] / 1e6:.1f}', f'{r["peak_bytes"] / 1e6:.1f}',
                     f'{r["build_s"]:.3f}', ratio("build_s"), str(r["builds"])])
    head = ["scene, structure", "triangles", "MB", f"times {REFERENCE}", "MB with buffers", "peak MB", "build s",
            f"times {REFERENCE}", "builds"]
    return Table(head, rows, "MB: 1e6 bytes, as each structure's own monitor counts. Seconds: median of the builds.", strong)


def memory(records, charts):
    builds = [r for r in records if r["kind"] == "build"]
    blocks = [charts[n] for n in ("bytes", "build-time") if n in charts]
    if "bytes-with-buffers" in charts:
        blocks.append(Fold("With the scene's own vertex and index buffers", [charts["bytes-with-buffers"]]))
    blocks.append(Fold("Every scene", [build_table(builds)]))
    return Section("memory", "Memory and build time", blocks)


# --- errors ---


def error_row(label, group):
    traced = sum(r["traced"] for r in group)
    cells = [Cell(number(traced))] + [bad_count(sum(r[key] for r in group), traced) for key, _ in WRONG]
    errors = [r["t_error_rel_p99"] for r in group if r["t_error_rel_p99"] is not None]
    return [label] + cells + [number(sum(r["within_rounding"] for r in group)), f"{max(errors, default=0):.1e}"]


def error(records):
    errors = [r for r in records if r["kind"] == "error"]
    head = ["structure", "rays"] + [label for _, label in WRONG] + ["within rounding", "t error"]
    by_structure = grouped(errors, "structure")
    names = [name for (name,) in by_structure]
    rows = [error_row(f"`{name}`", group) for (name,), group in by_structure.items()]
    scene_rows, strong = [], set()
    for (scene, name), group in grouped(errors, "scene", "structure").items():
        if is_ours(name):
            strong.add(len(scene_rows))
        scene_rows.append(error_row(f"{scene} `{name}`", group))
    caption = ("Within rounding: the exact answer itself changes if a number changes in its last bits. t error: the 99th "
               "percentile of the relative error of the distance, of the worst scene and kind of rays.")
    most = max(sum(r["traced"] for r in group) for group in by_structure.values())
    return Section("error", "Errors against an exact oracle", [
        Text("Rays as a renderer sends them. The oracle tests every triangle, in double precision where that is certain, else "
             f"in whole numbers of any length. A zero of {number(most)} rays proves a rate below {3 / most:.1e} with 95 % "
             "confidence."),
        Table(head, rows, caption, ours_among(names)), Fold("Every scene", [Table(head, scene_rows, "", strong)])])


HARD = (("leaks", "leaks"),) + tuple(WRONG) + (("any_hit_wrong", "any hit"),)


def hard_cell(record):
    if record is None:
        return Cell("-")
    found = [f"{number(record[key])} {word}" for key, word in HARD if record[key]]
    return Cell(", ".join(found), "bad") if found else Cell("0", "good")


def hard(records):
    hards = [r for r in records if r["kind"] == "hard"]
    names = sorted(distinct(r["structure"] for r in hards), key=lambda n: not is_ours(n))  # ours first
    by_key = {(r["family"], r["structure"]): r for r in hards}
    families = distinct(r["family"] for r in hards)
    rows = []
    for family in families:
        traced = max(r["traced"] for r in hards if r["family"] == family)
        rows.append([f"`{family}`", number(traced)] + [hard_cell(by_key.get((family, n))) for n in names])
    totals = ["all", number(sum(max(r["traced"] for r in hards if r["family"] == f) for f in families))]
    for name in names:
        wrong = sum(r[key] or 0 for r in hards if r["structure"] == name for key, _ in HARD)
        totals.append(Cell(number(wrong), "bad" if wrong else "good"))
    return Section("hard", "Hard cases", [
        Text("Rays and meshes that break ray tracers: aimed at vertices and edges of closed moving meshes, needles, slivers, "
             "far from the origin, times on steps. What is wrong beyond rounding:"),
        Table(["family", "rays"] + names, rows + [totals],
              "leaks: a ray from inside a closed mesh that hits nothing. any hit: wrong answers of occlusion rays. -: the "
              "structure cannot be asked.")])


def image_rmse(renders, structure):
    """Root of the mean square over the scenes; None without renderings. 0 for the reference."""
    squares = [(r["difference"] or {"rmse": 0})["rmse"] ** 2 for r in renders if r["structure"] == structure]
    return (sum(squares) / len(squares)) ** 0.5 if squares else None


def pareto(records, charts):
    points = [r for r in records if r["kind"] == "pareto"]
    renders = [r for r in records if r["kind"] == "render"]
    rows = []
    for r in points:
        image = image_rmse(renders, r["structure"])
        rows.append([f'`{r["structure"]}`', times(r["ratio_to_embree"]),
                     bad_count(r["leaks"], r["aimed"]), number(r["aimed"]), number(r["differing"]), number(r["thin"]),
                     f'{r["t_error_rel_p99"]:.1e}', f"{image:.1e}" if image is not None else "-"])
    head = ["structure", f"speed of {REFERENCE}", "leaks", "of", "differing", "of", "t error, far away", "picture RMSE"]
    table = Table(head, rows, "differing: answered otherwise than exactly at needles and slivers, within rounding too. picture "
                  "RMSE: of the renderings below against those of the same seed through an exact structure.",
                  ours_among([r["structure"] for r in points]))
    return Section("pareto", "Speed against error", [charts[n] for n in charts if n == "pareto"] + [table])


# --- the gallery ---


def gallery_cells(records, structure, scenes):
    """What a structure is and does over all scenes."""
    mine = [r for r in records if r["kind"] == "gallery" and r["structure"] == structure]
    summaries = {(r["measure"], r["rays"], r["reference"]): r for r in records
                 if r["kind"] == "summary" and r["structure"] == structure}
    against = mine[0]["compared_with"]
    kinds = distinct(r["rays"] for r in records if r["kind"] == "summary" and r["measure"] == "speed")
    for rays in kinds:
        r = summaries.get(("speed", rays, against))
        yield f'{r["mean_ratio"]:.2f}' if r else "-"
    r = summaries.get(("speed", together_of(kinds), against))
    yield spread(r, "mean_ratio") if r else "-"
    for key in ("nodes_per_ray", "leaves_per_ray"):
        values = [r[key] for r in mine if r[key]]
        yield f"{geometric_mean(values):.1f}" if values else "-"
    for measure in ("structure_bytes", "build_s"):
        r = summaries.get((measure, None, "stbvh-direct"))
        yield f'{r["mean_ratio"]:.2f}' if r else "-"
    traced, wrong = sum(r["traced"] for r in mine), sum(r["wrong"] for r in mine)
    yield bad_count(wrong, traced) if mine[0]["is_exact"] or wrong == 0 else Cell(f"{100 * wrong / traced:.2g} %")
    yield mine[0]["step_limit"]
    yield f'{sum(1 for r in mine if r["traced"])} of {scenes}'


def together_of(kinds):
    return max(kinds, key=lambda k: k.count("+")) if kinds else None


def gallery(records, charts):
    found = [r for r in records if r["kind"] == "gallery"]
    names = distinct(r["structure"] for r in found)
    scenes = len(distinct(r["scene"] for r in found))
    against = {r["structure"]: r["compared_with"] for r in found}
    rows = [[f"`{name}`" + (" *" if against[name] != "stbvh-direct" else ""), *gallery_cells(records, name, scenes)]
            for name in names]
    kinds = distinct(r["rays"] for r in records if r["kind"] == "summary" and r["measure"] == "speed")
    head = ["structure"] + [k.replace("+", " + ") for k in kinds] + ["least to largest", "nodes", "leaves", "bytes",
                                                                     "build time", "wrong", "steps", "scenes"]
    obstacles = grouped([r for r in found if r["obstacle"] is not None], "structure", "obstacle")
    blocks = [Text("The methods that came before the STBVH, and ours without its ideas one by one, all made of the same "
                   "parts: meshlets, leaves, triangle test, padding and collapse. Each answered the rays right, by the exact "
                   "oracle, before it was timed with them."),
              *[charts[n] for n in charts if n == "gallery"],
              Table(head, rows, "Speed, bytes and build time: times `stbvh-direct`. *: without vector instructions, speed times "
                    "`stbvh-direct-scalar`. Nodes and leaves: of a bounce or uniform ray. Geometric means over the scenes. "
                    "Wrong: answers beyond rounding. Steps: that a mesh may have.", ours_among(names))]
    blocks += [Text(f'`{structure}` does not take {", ".join(r["scene"] for r in group)}: {why}.')
               for (structure, why), group in obstacles.items()]
    blocks += [charts[n] for n in charts if n.startswith("gallery-")]
    return Section("gallery", "The gallery", blocks)


# --- pictures ---


def render_picture(r):
    return Picture(IMAGES + r["picture"], r["structure"],
                   f'{r["seconds"]:.1f} s, {r["mrays_per_s"]:.2f} million rays per second')


def difference_pictures(group):
    for r in group:
        d = r["difference"]
        if d and d["differing"]:
            yield Picture(IMAGES + d["picture"], f'{r["structure"]} against {d["reference"]}',
                          f'FLIP; {number(d["differing"])} of {number(r["width"] * r["height"])} pixels differ, RMSE '
                          f'{d["rmse"]:.2e}, mean FLIP {d["flip_mean"]:.2e}')


def heat_pictures(group):
    for r in group:
        for key, what in (("nodes", "nodes"), ("triangles", "triangle tests")):
            if r[key]:
                yield Picture(IMAGES + r[key]["picture"], f'{r["structure"]}: {what}',
                              f'for each camera ray; {r[key]["mean"]:.1f} in the mean, {r[key]["largest"]:.0f} at most')


def render_scene(scene, group, is_open):
    same = [r["structure"] for r in group if r["difference"] and not r["difference"]["differing"]]
    blocks = [Pictures([render_picture(r) for r in group])]
    differing = list(difference_pictures(group))
    if same:
        reference = next(r["difference"]["reference"] for r in group if r["difference"])
        words = ", ".join(f"`{name}`" for name in same)
        blocks.append(Text(f"No pixel differs from `{reference}`: {words}."))
    if differing:
        blocks.append(Pictures(differing, "FLIP: 0 (black) is the same, 1 (pale yellow) as different as can be seen."))
    heat = list(heat_pictures(group))
    if heat:
        blocks.append(Pictures(heat))
    return Fold(f"{scene}, {size_of(group[0])}", blocks, is_open)


def size_of(r):
    return f'{r["width"]} x {r["height"]}, {number(r["samples_per_pixel"])} samples for each pixel'


def renders(records):
    found = [r for r in records if r["kind"] == "render"]
    names = distinct(r["structure"] for r in found)
    scenes = distinct(r["scene"] for r in found)
    by_key = {(r["scene"], r["structure"]): r for r in found}
    rows = [[f"`{name}`"] + [f'{by_key[s, name]["seconds"]:.2f}' if (s, name) in by_key else "-" for s in scenes]
            for name in names]
    text = ("The same paths through each structure, with one seed. Pictures differ only where a structure answers otherwise; "
            "heat maps show what a camera ray meets in the tree.")
    return Section("renders", "Renderings", [
        Text(text), Table(["seconds"] + scenes, rows, "Tracing and shading on all threads, without the build.",
               ours_among(names)),
        *[render_scene(scene, group, scene == scenes[0]) for (scene,), group in grouped(found, "scene").items()]])


def truth(records, charts):
    found = sorted((r for r in records if r["kind"] == "truth"), key=lambda r: r["samples_per_pixel"])
    best = found[-1]
    rows = [[str(r["samples_per_pixel"]), f'{r["rmse"]:.2e}', f'{r["flip_mean"]:.2e}'] for r in found]
    text = (f'Is the blur right? The reference is the mean of {number(best["frozen_times"])} renderings of `{best["scene"]}` '
            f'that do not move: each of a scene frozen at its own time, through `{best["reference_structure"]}`. It knows '
            f'nothing of segments, temporal splits or moving bounds. `{best["structure"]}`, rendering the motion, comes '
            "closer and closer to it.")
    return Section("truth", "Motion blur truth", [
        Text(text),
        Pictures([Picture(IMAGES + best["reference_picture"], "Frozen times", f'the mean of {number(best["frozen_times"])}'),
                  Picture(IMAGES + best["picture"], best["structure"], f'{best["samples_per_pixel"]} samples per pixel'),
                  Picture(IMAGES + best["difference_picture"], "Difference", f'FLIP, {best["flip_mean"]:.2e} in the mean')]),
        *[charts[n] for n in charts if n == "truth"],
        Table(["samples per pixel", "RMSE", "mean FLIP"], rows,
              "Noise falls at least as one over the root of the samples, until that of the reference itself is reached.")])


# --- how it was made ---


def reproduce(files):
    machine = files[0]["machine"]
    rows = [[key.replace("_", " "), f"{value:.1f}" if isinstance(value, float) else str(value)] for key, value in machine.items()]
    rows.append(["commit", ", ".join(distinct(f["commit"] for f in files))])
    commands = [(f["name"], f["command"]) for f in files if f.get("command")]
    blocks = [Table(["machine", ""], rows)]
    if len(distinct(str(f["machine"]) for f in files)) > 1:
        blocks.append(Text("Not all parts were measured on the same machine: " + "; ".join(
            f'{f["name"]}: {f["records"][0]["origin"]}' for f in files) + "."))
    if commands:
        blocks += [Text("`stbvh-ab` is `out/bin/stbvh-ab` after `harness/run`. "
                        "`stbvh-ab report --from FOLDER -o FOLDER` makes this page "
                        "again without measuring."), Commands(commands)]
    return Section("reproduce", "Machine and commands", blocks)
