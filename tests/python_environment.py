#!/usr/bin/env python3
"""A Python environment with packages from PyPI for a test, below build/: made once, whole or not at all.

Usage: python_environment.py PACKAGE==VERSION...     Prints its folder. Exit code 77: the packages cannot be installed.
"""
import fcntl
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]


def environment(packages):
    """Its folder, named after the first package. Ends the program where it cannot be made."""
    name, _, version = packages[0].partition("==")
    folder = ROOT / f"build/{name}-python{sys.version_info.major}.{sys.version_info.minor}-{version}"
    folder.parent.mkdir(exist_ok=True)
    with open(f"{folder}.lock", "w", encoding="ascii") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "whole").exists():
            for command in (["/usr/bin/python3", "-m", "venv", "--clear", folder],
                            [folder / "bin/python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check",
                             "--retries", "1", "--timeout", "20", *packages]):
                done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
                if done.returncode != 0:
                    print(f"skipped: {packages[0]} cannot be installed (is there a network?): {done.stdout.strip()[-200:]}",
                          file=sys.stderr)
                    sys.exit(77)
            (folder / "whole").touch()
    return folder


if __name__ == "__main__":
    print(environment(sys.argv[1:]))
