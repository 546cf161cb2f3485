#!/usr/bin/env python3
"""stbvh-run: what it hands to the program, what it says where it cannot, and that it is not noticed otherwise.
Usage: stbvh_run_test.py STBVH_RUN"""

import json
import os
import resource
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

from embree_tools import require_tools, serves
from scenes import SCENES

STBVH_RUN = ""
LIBRARIES = []  # that are built
PRINT_VARIABLES = ["python3", "-c", "import os\nfor k in sorted(os.environ):\n"
                   "  if k.startswith(('STBVH', 'LD_PRELOAD')): print(k + '=' + os.environ[k])"]


def run(*arguments, **more):
    return subprocess.run([STBVH_RUN, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=120,
                          **more)


def linked_library(program):
    """The drop-in library for the Embree that the program is linked with."""
    listing = subprocess.run(["ldd", shutil.which(program)], capture_output=True, text=True, check=True).stdout
    return "libstbvh_preload4.so" if "libembree4.so" in listing else "libstbvh_preload.so"


class WithFolder(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="stbvh-run-test-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def script(self, text):
        path = self.folder / "script"
        path.write_text(text)
        path.chmod(0o755)
        return path

    def scene(self):
        path = self.folder / "torus.xml"
        path.write_text(SCENES["torus"][0]())
        return path

    def pathtracer(self, picture, size=24):
        return [*require_tools("pathtracer"), "-i", self.scene(), "--size", size, size, "--spp", 1, "-o", picture]


class Environment(WithFolder):
    def variables(self, *options, **more):
        done = run(*options, *PRINT_VARIABLES, **more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return dict(line.split("=", 1) for line in done.stdout.splitlines())

    def test_what_is_asked_for_reaches_the_program(self):
        self.assertEqual(self.variables()["STBVH_PRELOAD"], "1")
        self.assertEqual(self.variables()["STBVH_PRELOAD_ALL"], "0")
        self.assertEqual(self.variables()["STBVH_PRELOAD_PRESET"], "default")
        self.assertEqual(self.variables("--all")["STBVH_PRELOAD_ALL"], "1")
        self.assertEqual(self.variables("--preset", "fast")["STBVH_PRELOAD_PRESET"], "fast")
        self.assertNotIn("STBVH_PRELOAD_MAX_BYTES", self.variables())
        self.assertEqual(self.variables("--max-bytes", "1000000")["STBVH_PRELOAD_MAX_BYTES"], "1000000")
        self.assertEqual(self.variables("--verbose")["STBVH_PRELOAD_VERBOSE"], "1")
        self.assertEqual(self.variables("--off")["STBVH_PRELOAD"], "0")
        file = self.folder / "s.json"
        self.assertEqual(self.variables("--json", file)["STBVH_PRELOAD_STATISTICS"], str(file))

    def test_variables_of_the_caller_do_not_add_to_options(self):
        found = self.variables(env={**os.environ, "STBVH_PRELOAD_ALL": "1", "STBVH_PRELOAD": "0"})
        self.assertEqual((found["STBVH_PRELOAD"], found["STBVH_PRELOAD_ALL"]), ("1", "0"))

    def test_other_preloaded_libraries_stay(self):
        other = next(Path("/lib/x86_64-linux-gnu").glob("libm.so.6"))
        found = self.variables(env={**os.environ, "LD_PRELOAD": str(other)})["LD_PRELOAD"].split(":")
        self.assertEqual([Path(f).name for f in found[:-1]], LIBRARIES)
        self.assertEqual(found[-1], str(other))

    def test_a_blank_in_the_path_of_the_library_is_refused(self):
        folder = self.folder / "a folder"
        folder.mkdir()
        shutil.copy(STBVH_RUN, folder)
        (folder / LIBRARIES[0]).touch()
        done = subprocess.run([folder / "stbvh-run", "true"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 125)
        self.assertIn("blank", done.stderr)

    def test_without_the_library_it_says_where_it_looked(self):
        shutil.copy(STBVH_RUN, self.folder)
        done = subprocess.run([self.folder / "stbvh-run", "true"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 125)
        for words in (str(self.folder), *LIBRARIES):
            self.assertIn(words, done.stderr)

    def test_a_program_of_an_embree_without_its_library_is_refused(self):
        tool, = require_tools("pathtracer")
        shutil.copy(STBVH_RUN, self.folder)
        other = {"libstbvh_preload.so", "libstbvh_preload4.so"} - {linked_library(tool)}
        shutil.copy(Path(STBVH_RUN).parent / LIBRARIES[0], self.folder / other.pop())
        done = subprocess.run([self.folder / "stbvh-run", tool], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 125, done.stderr)
        self.assertIn(f"{linked_library(tool)} is not installed", done.stderr)

    def test_a_linked_program_gets_the_library_of_its_embree_alone(self):
        tool, = require_tools("pathtracer")
        done = run(tool, "--help", env={**os.environ, "LD_DEBUG": "libs"})
        loaded = {name for name in ("libstbvh_preload.so", "libstbvh_preload4.so") if f"/{name}" in done.stderr}
        self.assertEqual(loaded, {linked_library(tool)})


class Refusals(WithFolder):
    def expect(self, code, words, *arguments):
        done = run(*arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(words, done.stderr)
        self.assertNotIn("Traceback", done.stderr)

    def test_programs_that_cannot_be_run(self):
        self.expect(127, "no program 'pathtracerr'", "pathtracerr")
        self.expect(127, "no program", "")
        self.expect(126, "is a folder", "/tmp")
        self.expect(126, "may not be executed", "/etc/passwd")
        self.expect(126, "neither a program nor a script", self.script("no script\n"))
        self.expect(126, "neither a program nor a script", self.script("\x7fELF"))
        self.expect(126, "cannot be run", self.script("#!/no/such/interpreter\n"))

    def test_damaged_programs(self):
        data = Path(sys.executable).read_bytes()[:20000]
        for length in (5, 16, 19, 40, 63, 64, 100, 300):
            path = self.folder / "cut"
            path.write_bytes(data[:length])
            path.chmod(0o755)
            done = run(path)
            self.assertIn(done.returncode, (126,), f"{length}: {done.stderr}")
            self.assertNotIn("Traceback", done.stderr)

    def test_a_static_program(self):
        compiler = shutil.which("cc")
        if compiler is None:
            self.skipTest("no C compiler")
        source = self.folder / "s.c"
        source.write_text("int main(void) { return 0; }\n")
        built = subprocess.run([compiler, "-static", source, "-o", self.folder / "s"], check=False, capture_output=True)
        if built.returncode != 0:
            self.skipTest("the compiler cannot link statically")
        self.expect(126, "is static", self.folder / "s")

    def test_a_setuid_program(self):
        if os.getuid() != 0:
            self.skipTest("only root can make a program of another user")
        path = self.folder / "other"
        shutil.copy("/bin/true", path)
        os.chown(path, 12345, 12345)
        path.chmod(0o755 | stat.S_ISUID)
        self.expect(126, "setuid", path)

    def test_options(self):
        for arguments in ((), ("--nonsense", "true"), ("--preset", "slow", "true"), ("--repeats", "2", "true"),
                          ("--max-bytes", "0", "true"), ("--max-bytes", "1M", "true"),
                          ("--ab", "--repeats", "0", "true"), ("--ab", "--repeats", "x", "true"),
                          ("--ab", "--off", "true"), ("--",)):
            self.expect(2, "error:", *arguments)


class Ends(WithFolder):
    def test_exit_codes_are_passed_on(self):
        for code in (0, 1, 7, 255):
            self.assertEqual(run("sh", "-c", f"exit {code}").returncode, code)
            self.assertEqual(run("--off", "sh", "-c", f"exit {code}").returncode, code)

    def test_signals_that_end_the_program_end_it_too(self):
        for number in (signal.SIGTERM, signal.SIGKILL, signal.SIGSEGV, signal.SIGABRT):
            self.assertEqual(run("sh", "-c", f"kill -{int(number)} $$").returncode, -number)

    def test_signals_are_passed_on(self):
        for options in ((), ("--off",)):
            ready = self.folder / "ready"
            ready.unlink(missing_ok=True)
            program = self.script(f"#!/bin/sh\ntrap 'exit 42' TERM\ntouch {ready}\nwhile :; do sleep 0.05; done\n")
            child = subprocess.Popen([STBVH_RUN, *options, program], stderr=subprocess.DEVNULL)
            for _ in range(1200):
                if ready.exists():
                    break
                time.sleep(0.05)
            child.terminate()
            self.assertEqual(child.wait(60), 42)

    def test_a_broken_pipe_ends_the_program_as_without_it(self):
        done = subprocess.run(["bash", "-c", f"{STBVH_RUN} yes | head -1 > /dev/null; echo ${{PIPESTATUS[0]}}"],
                              capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.strip(), str(128 + signal.SIGPIPE))

    def test_arguments_and_input_arrive_unchanged(self):
        strange = ["--all", "a b", "", "$x", "{side}", "--", "*"]
        done = run("--", "python3", "-c", "import sys; print(sys.argv[1:], sys.stdin.read())", *strange, input="in")
        self.assertEqual(done.stdout, f"{strange} in\n")


class Embree(WithFolder):
    """With a program that is linked with Embree, and with some that are not."""

    def test_a_program_without_embree_is_told_after_the_run(self):
        done = run("true")
        self.assertEqual((done.returncode, done.stdout), (0, ""))
        self.assertEqual(len(done.stderr.splitlines()), 1)
        self.assertIn("has not used libembree", done.stderr)

    def test_statistics_of_a_linked_program(self):
        require_tools("pathtracer")
        file = self.folder / "s.json"
        done = run("--json", file, *self.pathtracer(self.folder / "o.ppm"))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(json.loads(file.read_text())["meshes_taken_over"], 2)
        done = run("--statistics", *self.pathtracer(self.folder / "o.ppm"))
        self.assertIn("meshes taken over: 2\n", done.stderr)

    def test_statistics_leave_what_is_special_as_it_is(self):
        """Through the library alone, through stbvh-run, and as the record of both sides."""
        require_tools("pathtracer")
        if os.getuid() != 0:
            self.skipTest("only root can make device nodes")
        device, full, link, later = (self.folder / name for name in ("null", "full", "link", "later"))
        os.mknod(device, 0o666 | stat.S_IFCHR, os.makedev(1, 3))
        os.mknod(full, 0o666 | stat.S_IFCHR, os.makedev(1, 7))
        link.symlink_to("later")
        program = self.pathtracer(self.folder / "o.ppm")
        for options in ((), ("--statistics",), ("--ab",)):
            with self.subTest(options=options):
                done = run("--json", device, *options, *program)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertNotIn("has not used", done.stderr)
                self.assertTrue(device.is_char_device())
                done = run("--json", link, *options, *program)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertTrue(link.is_symlink())
                self.assertIn("meshes_taken_over", later.read_text())
                later.unlink()
                done = run("--json", full, *options, *program)
                self.assertIn("No space left on device", done.stderr)
                self.assertTrue(full.is_char_device())
                done = run("--json", self.folder, *options, *program)
                self.assertIn("Is a directory", done.stderr)
        self.assertEqual({f.name for f in self.folder.iterdir()}, {"null", "full", "link", "o.ppm", "torus.xml"})

    def test_statistics_into_a_pipe(self):
        require_tools("pathtracer")
        pipe = self.folder / "pipe"
        os.mkfifo(pipe)
        for options in ((), ("--statistics",), ("--ab",)):
            with self.subTest(options=options):
                with open(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK), encoding="utf-8") as reader:
                    done = run("--json", pipe, *options, *self.pathtracer(self.folder / "o.ppm"))
                    self.assertEqual(done.returncode, 0, done.stderr)
                    self.assertIn("meshes_taken_over", reader.read())
        # A program does not wait at its end for somebody who reads.
        done = run("--json", pipe, *self.pathtracer(self.folder / "o.ppm"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f'the statistics: Nobody reads "{pipe}".', done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1)

    def test_a_script_that_starts_one_is_judged_by_what_it_started(self):
        require_tools("pathtracer")
        command = " ".join(map(str, self.pathtracer(self.folder / "o.ppm")))
        done = run("--statistics", self.script(f"#!/bin/sh\n{command}\nexit 5\n"))
        self.assertEqual(done.returncode, 5)
        self.assertIn("meshes taken over: 2\n", done.stderr)
        self.assertNotIn("has not used", done.stderr)

    def test_off_takes_nothing_over(self):
        require_tools("pathtracer")
        pictures = self.folder / "off.ppm", self.folder / "native.ppm"
        self.assertEqual(run("--off", *self.pathtracer(pictures[0])).returncode, 0)
        subprocess.run(list(map(str, self.pathtracer(pictures[1]))), check=True, stdout=subprocess.DEVNULL)
        self.assertEqual(pictures[0].read_bytes(), pictures[1].read_bytes())

    def test_ab_measures_both_sides_and_says_what_was_taken_over(self):
        require_tools("pathtracer")
        file = self.folder / "ab.json"
        done = run("--ab", "--repeats", 2, "--json", file, *self.pathtracer(self.folder / "{side}.ppm"))
        self.assertEqual(done.returncode, 0, done.stderr)
        record = json.loads(file.read_text())
        self.assertEqual([r["side"] for r in record["runs"]], ["native", "stbvh", "native", "stbvh"])
        self.assertEqual(record["statistics"]["meshes_taken_over"], 2)
        for side in record["runs"]:
            self.assertGreater(side["wall_seconds"], 0)
            self.assertGreater(side["peak_bytes"], 1e6)
        for word in ("wall seconds", "user seconds", "peak memory", "stbvh / native", "meshes taken over: 2"):
            self.assertIn(word, done.stderr)
        for name in ("native.ppm", "stbvh.ppm"):
            self.assertTrue((self.folder / name).exists())

    def test_ab_measures_what_the_program_uses(self):
        waste = "import os\nx = bytearray(300_000_000)\nwhile os.times().user < 0.3: pass"
        file = self.folder / "ab.json"
        self.assertEqual(run("--ab", "--json", file, "python3", "-c", waste).returncode, 0)
        for side in json.loads(file.read_text())["runs"]:
            self.assertGreater(side["user_seconds"], 0.25)
            self.assertTrue(3e8 < side["peak_bytes"] < 4e8, side)

    def test_ab_of_a_program_that_fails_ends_as_that(self):
        done = run("--ab", "sh", "-c", "exit 9")
        self.assertEqual(done.returncode, 9)
        self.assertIn("nothing to compare", done.stderr)

    def test_a_record_that_cannot_be_written_is_an_error(self):
        if os.getuid() != 0:
            self.skipTest("only root can make device nodes")
        full = self.folder / "full"
        os.mknod(full, 0o666 | stat.S_IFCHR, os.makedev(1, 7))
        done = run("--ab", "--json", full, "true")
        self.assertEqual(done.returncode, 1)
        self.assertIn("cannot be written", done.stderr)


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    STBVH_RUN = os.path.abspath(sys.argv.pop(1))
    LIBRARIES = ["libstbvh_preload4.so" if major == 4 else "libstbvh_preload.so" for major in serves(STBVH_RUN)]
    unittest.main()
