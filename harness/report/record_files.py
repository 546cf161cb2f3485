"""The files that stbvh-ab writes with --json, and those that are made of them. Needs Python's standard library only.

What goes wrong ends the script with exit code 2 (1 without memory) and one line on stderr.
"""
import errno
import itertools
import json
import math
import os
import re
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
    """Ends the script: one line on stderr, and not by Python's own end, in which libraries may wait for their threads."""
    for stream, last in ((sys.stdout, ""), (sys.stderr, f"stbvh-ab: {printable(text)}\n")):
        try:
            print(end=last, file=stream, flush=True)
        except (OSError, AttributeError, ValueError):  # it is full or closed
            pass
    os._exit(exit_code)


def end_with(error):
    """What nobody thought of ends the script with one line, too."""
    if isinstance(error, MemoryError) or isinstance(error, OSError) and error.errno == errno.ENOMEM:
        fail("Not enough memory.", 1)
    if isinstance(error, ImportError):
        fail(f"Charts need Debian's python3-matplotlib ({' '.join(str(error).split())[:200]}).")
    if isinstance(error, RecursionError):
        fail("The records are nested too deeply.")
    if isinstance(error, OSError):
        place = f'"{error.filename}"' if error.filename else "standard output"
        fail(f"Cannot read or write {place}: {error.strerror}.")
    if isinstance(error, KeyError):
        fail(f"Records lack the field {error}: they are of another version of stbvh-ab.")
    if isinstance(error, (ArithmeticError, AttributeError, IndexError, TypeError, ValueError)):
        fail(f"Records do not hold what they should: {error}.")
    fail(f"{type(error).__name__}: {error}.", 1)


# Also while modules are imported.
sys.excepthook = lambda kind, error, trace: end_with(error)


def run(main):
    """Runs a script."""
    if sys.stdout:
        sys.stdout.reconfigure(errors="backslashreplace")  # names of files need not be text
    main()
    if sys.stdout:
        sys.stdout.flush()


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


def read_bytes(path):
    """What a regular file holds, or a pipe that is open already (`<(...)` of a shell). Ends the script if it cannot be read.

    A pipe with a name may have nobody who writes, and a device no end.
    """
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
            mode = os.fstat(file.fileno()).st_mode
            if stat.S_ISFIFO(mode) and is_descriptor(target_of(path)):
                os.set_blocking(file.fileno(), True)
            elif not stat.S_ISREG(mode):
                fail(f'"{path}" is not a regular file.')
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        fail(f'Cannot read "{path}": {error.strerror}.')
    if len(data) > MOST_BYTES:
        fail(f'"{path}" has more than the {MOST_BYTES} bytes that are read of it.')
    return data


def parsed(path):
    """What a file of JSON holds. Ends the script if it cannot be read."""
    data = read_bytes(path)
    try:
        return json.loads(data.decode("utf-8-sig"), object_pairs_hook=checked_object, parse_float=checked_float,
                          parse_int=checked_int, parse_constant=checked_float)
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
MOST_LINKS = 40  # as Linux


def is_descriptor(path):
    """Whether it is the link to a file that a process has open: to the file, not to its name."""
    return re.fullmatch(r"/proc/\d+(/task/\d+)?/fd", os.path.realpath(os.path.dirname(path))) is not None


def target_of(path):
    """Where links lead to, also if nothing is there yet."""
    target = path
    for _ in range(MOST_LINKS + 1):
        if not os.path.islink(target) or is_descriptor(target):
            return target
        target = os.path.join(os.path.dirname(target), os.readlink(target))
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))


def is_replaced(target):
    """Whether writing there makes a file, or replaces one; what else there is, is opened and written to."""
    return not is_descriptor(target) and (os.path.isfile(target) or not os.path.exists(target))


def earlier_file(path):
    """What the file holds that write_whole() would replace; None where there is none. Ends the script if it cannot."""
    try:
        target = target_of(path)
    except OSError as error:
        fail(f'Cannot read "{path}": {error.strerror}.')
    return read_bytes(path) if is_replaced(target) and os.path.exists(target) else None


def open_to_write(target):
    """What there is; what this process has open goes on from where it stands."""
    folder, name = os.path.split(target)
    if os.path.realpath(folder) != os.path.realpath("/proc/self/fd") or not name.isdecimal():
        return os.open(target, os.O_WRONLY | os.O_APPEND)
    if sys.stdout:
        sys.stdout.flush()
    return os.dup(int(name))


def write_whole(path, data):
    """Writes bytes to a file, whole or not at all. A link stays a link; a device or pipe is written to directly, and so is what
    the program has open already.

    As write_file() of plugin/files. Ends the script if it cannot.
    """
    try:
        if not os.path.basename(path):
            raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
        target = target_of(path)
        if not is_replaced(target):
            with open(open_to_write(target), "wb") as file:
                file.write(data)
            return
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
