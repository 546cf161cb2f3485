#!/usr/bin/env python3
"""The checks of images.py themselves: what they must not let pass."""

import random
import tempfile
import unittest
from pathlib import Path

from embree_tools import Difference, native_trees_of_moving_triangles, read_ppm


def picture(folder, name, pixels, width=100):
    path = Path(folder) / name
    path.write_bytes(b"P6\n%d %d\n255\n" % (width, len(pixels) // 3 // width) + bytes(pixels))
    return path


class Pictures(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        source = random.Random(1)
        self.pixels = [source.randrange(20, 200) for _ in range(30000)]

    def difference(self, change):
        changed = list(self.pixels)
        change(changed)
        return Difference(picture(self.folder, "a.ppm", self.pixels), picture(self.folder, "b.ppm", changed))

    def test_the_same(self):
        found = self.difference(lambda p: None)
        self.assertEqual((found.pixels, found.differing, found.large, found.largest), (10000, 0, 0, 0))
        self.assertTrue(found.within_floats())

    def test_roundings_and_single_paths_are_let_pass(self):
        def change(p):
            for i in range(0, 900, 30):
                p[i] += 1
            p[3000] += 50
        found = self.difference(change)
        self.assertEqual((found.differing, found.large, found.largest), (31, 1, 50))
        self.assertTrue(found.within_floats())

    def test_what_roundings_do_not_explain_is_not(self):
        def everywhere_by_one(p):
            p[::3] = [x + 1 for x in p[::3]]

        def a_hole(p):
            p[:36] = [0] * 36

        def a_shift(p):
            p[3:] = p[:-3]
        for change in (everywhere_by_one, a_hole, a_shift):
            self.assertFalse(self.difference(change).within_floats(), change.__name__)

    def test_a_picture_of_nothing_shows_nothing(self):
        black = picture(self.folder, "c.ppm", [0] * 30000)
        self.assertEqual(Difference(black, black).shown, 0)

    def test_broken_files_are_refused(self):
        whole = picture(self.folder, "a.ppm", self.pixels)
        self.assertEqual(read_ppm(whole)[:2], (100, 100))
        for data in (b"", b"P5\n1 1\n255\nx", whole.read_bytes()[:-1]):
            broken = Path(self.folder) / "broken.ppm"
            broken.write_bytes(data)
            self.assertRaises(ValueError, read_ppm, broken)


class Trees(unittest.TestCase):
    def test_trees_over_moving_triangles_are_told_from_others(self):
        moving = ["building BVH8MB<triangle4i> using avx::BVH8BuilderMBlurSAH ...",
                  "building BVH4<triangle4imb> using avx::BVH4BuilderSAH ...",
                  "building BVH8MB<triangle4vMB> using avx::BVH8BuilderMBlurSAH ..."]
        others = ["building BVH8<triangle4> using avx::BVH8BuilderSAH ...", "finished BVH8MB<triangle4i> : 1ms",
                  "building BVH4MB<object> using avx::BVH4BuilderMBlurSAH ...",
                  "building BVH4MB<quad4i> using avx::BVH4BuilderMBlurSAH ..."]
        self.assertEqual(native_trees_of_moving_triangles("\n".join(moving + others)), moving)


if __name__ == "__main__":
    unittest.main()
