#!/usr/bin/env python3
"""What the preload library leaves alone: Embrees of other majors (tests/preload/other_embree stands for them, and says every
call that reaches it), and one that was built with other options or hands on what a query brings in another way.
Usage: other_embree_test.py STBVH_RUN FOLDER_OF_OTHER_EMBREE"""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from embree_tools import require_tools, serves
from scenes import SCENES

STBVH_RUN, FOLDER = "", Path()
LEFT_ALONE = "libstbvh_preload: this is for Embree {}; everything is left to this Embree {}\n"


def call_run(client, scope):
    """A program that loads an Embree as Python's modules do: out of other libraries' sight, or not."""
    return ["python3", "-c", f"import ctypes, os; ctypes.CDLL({str(client)!r}, os.{scope}).run()"]


class OtherVersions(unittest.TestCase):
    def test_every_call_reaches_it_unchanged(self):
        for major, calls in ((2, 1), (3, 42), (4, 42)):
            if major in serves(STBVH_RUN):
                continue
            client = FOLDER / f"libother_embree_client{major}.so"
            for scope in ("RTLD_LOCAL", "RTLD_GLOBAL"):
                with self.subTest(major=major, scope=scope):
                    command = call_run(client, scope)
                    native = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
                    ours = subprocess.run([STBVH_RUN, *command], capture_output=True, text=True, check=False, timeout=60)
                    self.assertEqual(ours.returncode, 0, ours.stderr)
                    self.assertGreater(native.stdout.count("\n"), calls)
                    self.assertEqual(ours.stdout, native.stdout)
                    for served in serves(STBVH_RUN):
                        self.assertEqual(ours.stderr.count(LEFT_ALONE.format(served, major)), 1, ours.stderr)
                    self.assertIn("has not used libembree", ours.stderr)


class OtherOptions(unittest.TestCase):
    """Ray masks, backface culling and filters, as an Embree that was built with or without them reports them."""

    REASON = "Embree without ray masks or filters, or with backface culling"
    RAY_MASKS, BACKFACE_CULLING, FILTERS = 64, 65, 66  # RTCDeviceProperty

    def setUp(self):
        self.pathtracer, = require_tools("pathtracer")
        folder = tempfile.TemporaryDirectory(prefix="stbvh-other-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.scene = self.folder / "torus.xml"
        self.scene.write_text(SCENES["torus"][0]())

    def render(self, name, prefix=(), **variables):
        picture = self.folder / name
        subprocess.run([*prefix, self.pathtracer, "-i", self.scene, "--size", "24", "24", "--spp", "1", "-o", picture],
                       env={**os.environ, **variables}, check=True, stdout=subprocess.DEVNULL, timeout=120)
        return picture.read_bytes()

    def statistics_behind(self, library, **variables):
        """Of a run with that library between Embree and ours, and its picture."""
        file = self.folder / "statistics.json"
        picture = self.render("ours.ppm", (STBVH_RUN, "--json", file), LD_PRELOAD=str(FOLDER / library), **variables)
        return json.loads(file.read_text()), picture

    def statistics_with(self, property_number, value):
        """Of a run whose Embree gives this for a device property, and its picture."""
        return self.statistics_behind("libother_device_property.so", EMBREE_PROPERTY=str(property_number),
                                      EMBREE_VALUE=str(value))

    def test_all_is_left_to_such_an_embree(self):
        native = self.render("native.ppm")
        for number, value in ((self.RAY_MASKS, 0), (self.BACKFACE_CULLING, 1), (self.FILTERS, 0)):
            with self.subTest(property=number):
                statistics, picture = self.statistics_with(number, value)
                self.assertEqual((statistics["meshes_taken_over"], statistics["rays"]), (0, 0))
                self.assertEqual(statistics["meshes_left_native"].get(self.REASON), 1)
                self.assertEqual(picture, native)

    def test_all_is_left_to_an_embree_that_lays_out_queries_otherwise(self):
        library = "libother_query_layout.so"
        if not (FOLDER / library).exists():
            self.skipTest("Embree 3 has one layout")
        native = self.render("native.ppm")
        for hidden in ("options", "instPrimID"):
            with self.subTest(hidden=hidden):
                statistics, picture = self.statistics_behind(library, EMBREE_HIDES=hidden)
                self.assertEqual((statistics["meshes_taken_over"], statistics["rays"]), (0, 0))
                self.assertEqual(statistics["meshes_left_native"].get("Embree that lays out queries otherwise"), 1)
                self.assertEqual(picture, native)
        statistics, _ = self.statistics_behind(library, EMBREE_HIDES="nothing")
        self.assertEqual(statistics["meshes_taken_over"], 2)

    def test_what_debian_built_is_taken_over(self):
        statistics, _ = self.statistics_with(self.RAY_MASKS, 1)
        self.assertEqual(statistics["meshes_taken_over"], 2)
        self.assertEqual(statistics["meshes_left_native"], {})


if __name__ == "__main__":
    STBVH_RUN, FOLDER = os.path.abspath(sys.argv.pop(1)), Path(sys.argv.pop(1)).resolve()
    unittest.main()
