#!/usr/bin/env python3
"""`run --resume` after every way in which a run can end too early.

    resume_test.py PROGRAM

Each test lets a run be cut off, goes on from what is left, and compares the result with that of a run that nothing
cut off: byte for byte, timings apart (scripts/same-results).
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(sys.argv[1]).resolve()

EXPERIMENT = """
name = "tiny"
[scene]
mesh = "builtin:plane"
parameters.size_mm = 20.0
parameters.edge_mm = 5.0
[[light]]
direction = [0.0, 0.5, 1.0]
[[view]]
name = "front"
eye_mm = [0.0, 0.0, 100.0]
fov_deg = 10.0
width_px = 24
height_px = 24
[[view]]
name = "side"
eye_mm = [30.0, 0.0, 90.0]
fov_deg = 10.0
width_px = 24
height_px = 24
[[profile]]
name = "spike-and-base"
[[profile]]
name = "fitted"
fit.gaussians = 1
of = {model = "classical-dipole", material = "skin1"}
[[method]]
name = "none"
[[method]]
name = "pscbf"
[[method]]
name = "texture-space"
settings.texture_size = 64
[[ladder]]
name = "filter"
[[ladder.rung]]
truth = "whole"
assumption = "none"
[[ladder.rung]]
truth = "cut"
assumption = "the kernel ends at r_max"
[composite]
[stability]
jitter = {views = 2}
points = 50
[timing]
warm_up = 0
repeats = 1
"""
# Of one view: itself, two profiles' truths, their three runs and one ladder each, stability; and once the widths.
PIECES = 2 * (1 + 2 + 6 + 2 + 1) + 1


class Resume(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.TemporaryDirectory()
        cls.reference = pathlib.Path(cls.shared.name) / "reference"
        (pathlib.Path(cls.shared.name) / "e.toml").write_text(EXPERIMENT)
        subprocess.run([PROGRAM, "run", "e.toml", "--out", "reference", "--no-cache", "--buffers"], cwd=cls.shared.name, check=True,
                       capture_output=True)

    @classmethod
    def tearDownClass(cls):
        cls.shared.cleanup()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "out"
        (self.folder / "e.toml").write_text(EXPERIMENT)

    def command(self, *arguments):
        return [PROGRAM, "run", "e.toml", "--out", "out", "--no-cache", "--buffers", *arguments]

    def run_program(self, *arguments):
        return subprocess.run(self.command(*arguments), cwd=self.folder, capture_output=True, text=True)

    def left(self):
        return sorted(self.folder.glob(".out.*.part"))

    @staticmethod
    def pieces_in(folder):
        return list(folder.glob("[!.k]*.json"))

    def pieces(self):
        return [p for folder in self.left() for p in self.pieces_in(folder / "pieces")]

    def cut_off(self, after, how=signal.SIGKILL):
        """Ends a run by a signal when that many pieces are finished; returns its exit code and what it said."""
        with subprocess.Popen(self.command(), cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              text=True) as process:
            own = self.folder / f".out.{process.pid}.part/pieces"
            while process.poll() is None and not ((own / "key.json").exists() and len(self.pieces_in(own)) >= after):
                time.sleep(0.01)
            process.send_signal(how)
            said = process.stderr.read()
        return process.returncode, said

    def expect_the_same(self, reference=None):
        compared = subprocess.run([ROOT / "scripts/same-results", reference or self.reference, self.out],
                                  capture_output=True, text=True)
        self.assertEqual(compared.stdout, "")
        self.assertEqual(compared.returncode, 0, compared.stderr)
        self.assertEqual({p.name for p in self.folder.iterdir()} - {"whole"}, {"e.toml", "out"})

    def test_after_a_kill_at_any_piece(self):
        for after in range(0, PIECES + 1, 4):
            with self.subTest(after=after):
                code, _ = self.cut_off(after)
                self.assertEqual(code, -signal.SIGKILL)
                finished = len(self.pieces())
                self.assertGreaterEqual(finished, after)
                resumed = self.run_program("--resume")
                self.assertEqual(resumed.returncode, 0, resumed.stderr)
                if finished > 0:
                    self.assertIn(f"{finished} of {PIECES} pieces are finished", resumed.stderr)
                self.expect_the_same()
                subprocess.run(["rm", "-r", self.out], check=True)

    def test_after_several_kills_in_a_row(self):
        # A ladder that reads the pictures of runs, which were drawn before the kill.
        rung = 'method = "none"'
        (self.folder / "e.toml").write_text(EXPERIMENT.replace('truth = "cut"', rung))
        subprocess.run([PROGRAM, "run", "e.toml", "--out", "whole", "--no-cache", "--buffers"], cwd=self.folder, check=True,
                       capture_output=True)
        for after in (3, 5, 9, 15):
            arguments = ["--resume"] if self.left() else []
            with subprocess.Popen(self.command(*arguments), cwd=self.folder, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL) as process:
                while process.poll() is None and len(self.pieces()) < after:
                    time.sleep(0.01)
                process.kill()
        self.assertEqual(len(self.left()), 1)
        self.assertEqual(self.run_program("--resume").returncode, 0)
        self.expect_the_same(self.folder / "whole")

    def test_an_interrupted_run_says_how_to_go_on(self):
        for how in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(how=how):
                code, said = self.cut_off(2, how)
                self.assertEqual(code, -how)
                self.assertIn("interrupted; what is finished is kept; the same command with --resume goes on", said)
        self.assertEqual(self.run_program("--resume").returncode, 0)
        self.expect_the_same()

    def test_after_a_full_disk(self):
        # No file may grow beyond some KiB: the first that is larger cannot be written, as on a full disk.
        failures = set()
        for blocks in (16, 48, 96, 128):
            command = f"trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\""
            resume = ["--resume"] if self.left() else []
            limited = subprocess.run(["/bin/sh", "-c", command, *self.command(*resume)], cwd=self.folder,
                                     capture_output=True, text=True)
            if limited.returncode == 0:
                break
            self.assertEqual(limited.returncode, 3, limited.stderr)
            self.assertIn("cannot write", limited.stderr)
            self.assertIn("the same command with --resume goes on from it", limited.stderr)
            failures.add(len(self.pieces()))
        self.assertGreaterEqual(len(failures), 2)
        self.assertEqual(self.run_program("--resume").returncode, 0)
        self.expect_the_same()

    def test_a_changed_experiment_is_not_resumed(self):
        self.cut_off(5)
        finished = len(self.pieces())
        (self.folder / "e.toml").write_text(EXPERIMENT.replace("repeats = 1", "repeats = 2"))
        refused = self.run_program("--resume")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("cannot be resumed: experiment was", refused.stderr)
        self.assertEqual(len(self.pieces()), finished)
        (self.folder / "e.toml").write_text(EXPERIMENT)
        self.assertEqual(self.run_program("--resume").returncode, 0)
        self.expect_the_same()

    def test_a_run_without_its_buffers_is_not_resumed_with_them(self):
        with subprocess.Popen([a for a in self.command() if a != "--buffers"], cwd=self.folder,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            while process.poll() is None and len(self.pieces()) < 3:
                time.sleep(0.01)
            process.kill()
        refused = self.run_program("--resume")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("cannot be resumed: exports/0 was null and is \"buffers\"", refused.stderr)

    def test_a_changed_input_is_not_resumed(self):
        def write_mesh(height):
            (self.folder / "m.obj").write_text(f"v -9 -9 0\nv 9 -9 0\nv 0 9 {height}\nf 1 2 3\n")

        text = EXPERIMENT.replace('"builtin:plane"', '"m.obj"')
        text = "\n".join(line for line in text.split("\n") if not line.startswith("parameters."))
        (self.folder / "e.toml").write_text(text)
        write_mesh(0)
        self.cut_off(5)
        write_mesh(1)
        refused = self.run_program("--resume")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("cannot be resumed: inputs/m.obj was", refused.stderr)

    def test_without_resume_a_run_starts_anew_and_clears_up_at_its_end(self):
        self.cut_off(5)
        anew = self.run_program()
        self.assertEqual(anew.returncode, 0)
        self.assertIn("--resume goes on from it, and it is removed when this run is through", anew.stderr)
        self.assertNotIn("pieces are finished", anew.stderr)
        self.expect_the_same()

    def test_a_run_that_starts_anew_and_is_cut_off_too_loses_nothing(self):
        self.cut_off(12)
        self.cut_off(1)
        self.assertEqual(len(self.left()), 2)
        self.assertGreaterEqual(len(self.pieces()), 13)

    def test_with_nothing_to_go_on_from_it_begins_and_says_so(self):
        resumed = self.run_program("--resume")
        self.assertEqual(resumed.returncode, 0)
        self.assertIn("starting from the beginning", resumed.stderr)
        self.expect_the_same()

    def test_a_dry_run_resumes_nothing(self):
        self.cut_off(5)
        refused = self.run_program("--resume", "--dry-run")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--dry-run excludes --resume", refused.stderr)
        self.assertGreaterEqual(len(self.pieces()), 5)

    def test_an_earlier_result_stays_until_the_end(self):
        self.run_program("--set", "name=before")
        self.cut_off(5)
        self.assertEqual(json.loads((self.out / "results.json").read_text())["experiment"]["name"], "before")
        self.assertEqual(self.run_program("--resume").returncode, 0)
        self.expect_the_same()

    def test_a_damaged_piece_is_named(self):
        self.cut_off(8)
        damaged = sorted(self.pieces())[0]
        damaged.write_text("{")
        resumed = self.run_program("--resume")
        self.assertEqual(resumed.returncode, 3)
        self.assertIn(f"{damaged.name}: this finished piece of a run is no JSON", resumed.stderr)


if __name__ == "__main__":
    os.environ["TRUESCATTER_CACHE_LIMIT_MIB"] = "0"
    unittest.main(argv=[sys.argv[0], "-v"])
