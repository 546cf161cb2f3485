"""What the scripts that draw records share: names to colours, the footer, saving.

Needs Debian's python3-matplotlib. What goes wrong ends the script with exit code 2 and one line on stderr.
"""
import io
import logging
import mmap
import os
import tempfile
import warnings

from record_files import distinct, write_whole

ROOM = 512 << 20  # address space for matplotlib: OpenBLAS, which does its arithmetic, waits for ever where it has less


def import_matplotlib():
    """Without threads, and without what the user's environment, folders and the current folder say about it."""
    mmap.mmap(-1, ROOM).close()
    os.environ.update(OPENBLAS_NUM_THREADS="1", MPLBACKEND="Agg")
    os.environ.pop("MATPLOTLIBRC", None)
    here = os.open(".", os.O_PATH)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["MPLCONFIGDIR"] = folder
        os.chdir(folder)
        try:
            import matplotlib.colors
            import matplotlib.pyplot
        finally:
            os.fchdir(here)
            os.close(here)
    return matplotlib


matplotlib = import_matplotlib()
plt = matplotlib.pyplot

# matplotlib's, of names in scripts that the font lacks and the like.
warnings.simplefilter("ignore", UserWarning)
logging.disable()

# The same records give the same bytes: no random ids, no date.
matplotlib.rcParams["svg.hashsalt"] = "stbvh"
plt.rcParams.update({"text.parse_math": False, "font.size": 8, "axes.titlesize": 9, "axes.grid": True,
                     "grid.linewidth": 0.3, "axes.axisbelow": True})

# Okabe and Ito's colours, which are told apart with any kind of colour vision; a family of structures each.
COLOURS = ("#0072b2", "#e69f00", "#d55e00", "#009e73", "#cc79a7", "#56b4e9")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*", "p", "h")
LINES = ("-", "--", ":", "-.")


def family(structure):
    """The first word of a structure's name; its variants share a colour."""
    return structure.split("-")[0]


def lighter(colour, share):
    """The colour mixed with that share of white."""
    return tuple(1 - (1 - c) * (1 - share) for c in matplotlib.colors.to_rgb(colour))


def styles(structures):
    """Colour, marker and line of each structure: the hue says the family; lightness, marker and line the variant."""
    families = distinct(map(family, structures))
    found = {}
    for index, name in enumerate(families):
        members = [s for s in structures if family(s) == name]
        for variant, structure in enumerate(members):
            found[structure] = {
                "color": lighter(COLOURS[index % len(COLOURS)], 0.55 * variant / len(members)),
                "marker": MARKERS[variant % len(MARKERS)],
                "linestyle": LINES[variant % len(LINES)],
            }
    return found


def whiskers(records, key):
    """How far below and above `key` its least and largest lie, as errorbar and barh take them."""
    return [[r[key] - r[key + "_min"] for r in records], [r[key + "_max"] - r[key] for r in records]]


def log_scale(axes):
    """A logarithmic y axis whose numbers are plain texts: formulas are not parsed, as names may hold a $."""
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter("{x:g}")


def finish(figure, records, title, text="", legend_height=0.0):
    """Lays the figure out below its title and above a footer that says where `records` come from, then `text`.

    legend_height: inches to leave free above the footer.
    """
    height = figure.get_size_inches()[1]
    lines = distinct(r["origin"] for r in records)
    if text:
        lines.append(text)
    figure.suptitle(title, fontsize=10, y=1 - 0.08 / height, va="top")
    figure.text(0.01, 0.05 / height, "\n".join(lines), fontsize=6, va="bottom")
    bottom = legend_height + 0.1 + 0.1 * len(lines)
    figure.tight_layout(rect=(0, bottom / height, 1, 1))


def save(figure, path):
    """Writes the figure: the path's ending says how. Ends the script if it cannot."""
    extension = os.path.splitext(path)[1].lstrip(".")
    picture = io.BytesIO()
    try:
        figure.savefig(picture, format=extension, dpi=150, metadata={"Date": None} if extension == "svg" else None)
    finally:
        plt.close(figure)
    write_whole(path, picture.getvalue())
