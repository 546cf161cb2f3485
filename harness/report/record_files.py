"""The files that stbvh-ab writes with --json, and those that are made of them. Needs Python's standard library only.

What goes wrong ends the script with exit code 2 (1 without memory) and one line on stderr.
"""
import itertools
import json
import math
import os
import signal
import stat
import sys

# As other programs: ctrl-C (blocked by who runs the script) and a closed pipe end it without a word.
signal.signal(signal.SIGINT, signal.SIG_DFL)
signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
signal.signal(signal.SIGPIPE, signal.SIG_DFL)

MOST_BYTES = 64 << 20  # of a file of records
MOST_DIGITS = 20  # of a whole number


def printable(text):
    """The text in one line that any terminal can show."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def fail(text, exit_code=2):
    """Ends the script: one line on stderr."""
    print(f"stbvh-ab: {printable(text)}", file=sys.stderr)
    sys.exit(exit_code)


def run(main):
    """Runs a script. Also what nobody thought of ends it with one line."""
    try:
        main()
        sys.stdout.flush()
    except MemoryError:
        fail("Not enough memory.", 1)
    except RecursionError:
        fail("The records are nested too deeply.")
    except OSError as error:
        place = f'"{error.filename}"' if error.filename else "standard output"
        fail(f"Cannot read or write {place}: {error.strerror}.")
    except KeyError as error:
        fail(f"Records lack the field {error}: they are of another version of stbvh-ab.")
    except (ArithmeticError, AttributeError, IndexError, TypeError, ValueError) as error:
        fail(f"Records do not hold what they should: {error}.")


# --- reading ---


def checked_object(pairs):
    """An object of JSON. Texts become printable: they go into pages and pictures."""
    found = {}
    for key, value in pairs:
        if key in found:
            raise ValueError(f'"{key}" stands twice in one object')
        found[key] = printable(value) if isinstance(value, str) and key != "command" else value
    return found


def checked_float(text):
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:MOST_DIGITS]} is not a finite number")
    return value


def checked_int(text):
    if len(text) > MOST_DIGITS:
        raise ValueError(f"{text[:MOST_DIGITS]}... has too many digits")
    return int(text)


def parsed(path):
    """What a file of JSON holds. Ends the script if it cannot be read."""
    try:
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            fail(f'"{path}" has more than the {MOST_BYTES} bytes that are read of records.')
        return json.loads(data.decode("utf-8-sig"), object_pairs_hook=checked_object, parse_float=checked_float,
                          parse_int=checked_int, parse_constant=checked_float)
    except OSError as error:
        fail(f'Cannot read "{path}": {error.strerror}.')
    except ValueError as error:
        fail(f'"{path}" is not whole JSON: {error}.')
    except RecursionError:
        fail(f'"{path}" is nested too deeply.')


def machine_type(report):
    """What two machines have in common whose times may be compared, in words."""
    machine = report["machine"]
    return f'{machine["cpu"]}, {machine["cores"]} cores, Embree {machine["embree"]}'


def read_file(path):
    """What a file holds: "machine", "commit", "records" and, of newer files, "command".

    Ends the script if the file cannot be read, is not what stbvh-ab writes or holds no records.
    """
    report = parsed(path)
    if isinstance(report, dict) and report.get("records") == []:
        fail(f'There are no records in "{path}".')
    try:
        origin = f'{machine_type(report)}, stbvh {report["commit"]}'
        report["records"] = [{**record, "kind": record["kind"], "origin": origin} for record in report["records"]]
        for record in report["records"]:
            check_record(record, path)
    except (KeyError, TypeError):
        fail(f'"{path}" does not hold records of stbvh-ab.')
    return report


# Fields of records; all others are numbers.
TEXTS = {"kind", "scene", "structure", "family", "reference", "measure", "rays", "over", "what", "worst_scene", "origin",
         "picture", "reference_structure", "reference_picture", "difference_picture", "compared_with", "step_limit", "obstacle"}
HOLDERS = {"ratios_to_embree", "difference", "differences", "nodes", "triangles", "worst", "warnings", "shapes"}


def check_record(record, path):
    """Ends the script if a field holds something else than its kind, or null."""
    for key, value in record.items():
        kinds = str if key in TEXTS else (int, float, list, dict) if key in HOLDERS else (int, float)
        if value is not None and (not isinstance(value, kinds) or isinstance(value, bool)):
            fail(f'"{path}" has a record whose "{key}" is not {"a text" if key in TEXTS else "a number"}.')


def read_records(paths):
    """The records of all files, in order; each with its file's machine and commit in "origin".

    Ends the script if not all are of machines of one type.
    """
    files = [read_file(path) for path in paths]
    types = [machine_type(file) for file in files]
    for path, kind in zip(paths, types):
        if kind != types[0]:
            fail(f'"{paths[0]}" and "{path}" were measured on machines of two types: {types[0]}; {kind}.')
    return [record for file in files for record in file["records"]]


def distinct(values):
    """Each value once, in the order in which they first occur."""
    return list(dict.fromkeys(values))


def grouped(records, *keys):
    """The records in groups that agree in all keys, each under its values."""
    groups = {}
    for r in records:
        groups.setdefault(tuple(r[k] for k in keys), []).append(r)
    return groups


# What a record is about: no two may agree in all of these.
IDENTITY = ("kind", "scene", "family", "structure", "reference", "measure", "rays", "threads", "over", "value", "edit",
            "frames", "samples_per_pixel", "time")


def check_distinct(records):
    """Ends the script if two records say the same of the same."""
    seen = set()
    for r in records:
        identity = tuple(r.get(key) for key in IDENTITY)
        if identity in seen:
            fail("Two of the files have records of the same: " + ", ".join(str(i) for i in identity if i is not None)
                 + ".")
        seen.add(identity)


# --- writing ---


def make_folder(path):
    """Makes a folder, and those above it, if it is not there. Ends the script if it cannot."""
    try:
        os.makedirs(path, exist_ok=True)
    except OSError as error:
        fail(f'Cannot make the directory "{path}": {error.strerror}.')


PARTIAL_NAMES = itertools.count()


def write_whole(path, data):
    """Writes bytes to a file, whole or not at all. A link stays a link; a device or pipe is written to directly.

    As write_file() of plugin/files. Ends the script if it cannot.
    """
    try:
        if os.path.exists(path) and not stat.S_ISREG(os.stat(path).st_mode):
            with open(path, "wb", buffering=0) as file:
                file.write(data)
            return
        target = os.path.realpath(path)
        partial = f"{target}.{os.getpid()}-{next(PARTIAL_NAMES)}.partial"
        try:
            with open(partial, "xb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.replace(partial, target)
        except BaseException:
            if os.path.exists(partial):
                os.unlink(partial)
            raise
    except OSError as error:
        fail(f'Cannot write to "{path}": {error.strerror}.')
