"""The files that stbvh-ab writes with --json. Needs Python's standard library only.

What goes wrong ends the script with exit code 2 and one line on stderr.
"""
import json
import sys


def fail(text):
    """Ends the script: one line on stderr, exit code 2."""
    print(f"stbvh-ab: {text}", file=sys.stderr)
    sys.exit(2)


def read_file(path):
    """What a file holds: "machine", "commit", "records" and, of newer files, "command".

    Ends the script if the file cannot be read, is not what stbvh-ab writes or holds no records.
    """
    try:
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
        machine = report["machine"]
        origin = f'{machine["cpu"]}, {machine["cores"]} cores, Embree {machine["embree"]}, stbvh {report["commit"]}'
        report["records"] = [{**record, "kind": record["kind"], "origin": origin} for record in report["records"]]
    except OSError as error:
        fail(f'Cannot read "{path}": {error.strerror}.')
    except ValueError as error:
        fail(f'"{path}" is not whole JSON: {error}.')
    except (KeyError, TypeError):
        fail(f'"{path}" does not hold records of stbvh-ab.')
    if not report["records"]:
        fail(f'There are no records in "{path}".')
    return report


def read_records(paths):
    """The records of all files, in order; each with its file's machine and commit in "origin"."""
    return [record for path in paths for record in read_file(path)["records"]]


def distinct(values):
    """Each value once, in the order in which they first occur."""
    return list(dict.fromkeys(values))


def grouped(records, *keys):
    """The records in groups that agree in all keys, each under its values."""
    groups = {}
    for r in records:
        groups.setdefault(tuple(r[k] for k in keys), []).append(r)
    return groups
