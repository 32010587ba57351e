#!/usr/bin/env python3
"""`run --part` and `merge`: an experiment in parts is the experiment.

    parts_test.py PROGRAM

Parts, some of them killed and resumed, are merged and compared with a run that nothing divided: byte for byte, timings
apart (scripts/same-results).
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(sys.argv[1]).resolve()

EXPERIMENT = (ROOT / "tests/scripts/parts.toml").read_text()
# A ladder out of a method's picture: what it needs stays together.
WITH_PICTURES = EXPERIMENT.replace('truth = "cut"', 'method = "none"')
STABILITY = EXPERIMENT[EXPERIMENT.index("[stability]"):EXPERIMENT.index("[sweep]")]
# One scene, whose truths have audits along the surface, light by its ways, and a profile that Gaussians stand for.
OF_A_DIPOLE = """weight = [1.0, 1.0, 1.0]
[profile.of]
model = "classical-dipole"
sigma_a = 0.03
sigma_s_prime = 2.0
eta = 1.3
tolerance = 1e-3
"""
WITH_LIGHT_THROUGH = "\n".join(
    [EXPERIMENT[:EXPERIMENT.index("[sweep]")].replace("weight = [1.0, 1.0, 1.0]\n", OF_A_DIPOLE),
     '[[method]]\nname = "pscbf-transmit"', "[truth]\nlight_paths = 16", EXPERIMENT[EXPERIMENT.index("[timing]"):]])

# Runs a job at once, an array's tasks one after the other.
SBATCH = """#!/usr/bin/env bash
set -e
script=$(mktemp)
cat >"$script"
for argument in "$@"; do
  case $argument in
    --array=1-*) count=${argument#--array=1-} ;;
    --output=*) log=${argument#--output=} ;;
  esac
done
printf '%s\\n' "$@" >>"$SBATCH_ARGUMENTS"
for index in $(seq "${count:-1}"); do SLURM_ARRAY_TASK_ID=$index bash "$script" >"${log/\\%a/$index}" 2>&1; done
rm "$script"
echo 7
"""


class Parts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.environment = os.environ | {"TRUESCATTER_CACHE": str(self.folder / "cache")}
        self.write(EXPERIMENT)

    def write(self, text):
        (self.folder / "e.toml").write_text(text)

    def truescatter(self, *arguments):
        return subprocess.run([PROGRAM, *arguments], cwd=self.folder, env=self.environment, capture_output=True, text=True)

    def start(self, part, *arguments):
        return subprocess.Popen([PROGRAM, "run", "e.toml", "--part", part, "--out", f"parts/{part.replace('/', '-')}",
                                 *arguments], cwd=self.folder, env=self.environment, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True)

    def run_part(self, part, *arguments):
        with self.start(part, *arguments) as process:
            said = process.communicate()[1]
        self.assertEqual(process.returncode, 0, said)
        return said

    def parts(self, count):
        return [f"parts/{index}-{count}" for index in range(1, count + 1)]

    def merge(self, *parts):
        return self.truescatter("merge", *parts, "--out", "merged")

    def expect_the_same(self, count):
        merged = self.merge(*reversed(self.parts(count)))
        self.assertEqual(merged.returncode, 0, merged.stderr)
        self.assertEqual(merged.stdout, "merged/report.html\n")
        self.expect_whole("merged")

    def expect_whole(self, result):
        compared = subprocess.run([ROOT / "scripts/same-results", self.folder / "whole", self.folder / result],
                                  capture_output=True, text=True)
        self.assertEqual(compared.stdout + compared.stderr, "")
        self.assertEqual(compared.returncode, 0)

    def run_at_once(self, count):
        """All parts side by side; how many truths they computed."""
        for process in [self.start(f"{index}/{count}") for index in range(1, count + 1)]:
            said = process.communicate()[1]
            self.assertEqual(process.returncode, 0, said)
        return sum(json.loads((self.folder / part / "part.json").read_text())["truths"]["computed"]
                   for part in self.parts(count))

    def kill_at_a_piece(self, part):
        """Ends a part when its first piece is finished; returns the folder of what it leaves."""
        pieces = f"parts/.{part.replace('/', '-')}.*.part/pieces"
        with self.start(part) as process:
            while process.poll() is None and not list(self.folder.glob(f"{pieces}/[!.k]*.json")):
                time.sleep(0.001)
            process.send_signal(signal.SIGKILL)
        self.assertEqual(process.returncode, -signal.SIGKILL)
        return next(self.folder.glob(pieces))

    def run_whole(self, *arguments):
        whole = self.truescatter("run", "e.toml", "--out", "whole", "--no-cache", *arguments)
        self.assertEqual(whole.returncode, 0, whole.stderr)

    def pieces_of(self, part):
        return json.loads((self.folder / "parts" / part.replace("/", "-") / "part.json").read_text())["pieces"]

    def list_pieces(self, count):
        """The part of each piece, as --dry-run says."""
        listed = {}
        for index in range(1, count + 1):
            said = self.truescatter("run", "e.toml", "--part", f"{index}/{count}", "--dry-run")
            self.assertEqual(said.returncode, 0, said.stderr)
            for line in said.stdout.splitlines():
                if line.startswith("piece "):
                    piece = line.split()[1].rstrip(":")
                    self.assertNotIn(piece, listed)
                    self.assertIn("nothing of it is kept", line)
                    listed[piece] = index
        return listed

    def test_one_three_or_eight_are_the_whole(self):
        self.write(WITH_PICTURES)
        self.run_whole("--buffers")
        for count in (1, 3, 8):
            with self.subTest(count=count):
                for index in range(1, count + 1):
                    self.run_part(f"{index}/{count}", "--buffers")
                self.expect_the_same(count)
                shared = [run["cost"]["frame_ms"].get("shared", False)
                          for run in json.loads((self.folder / "merged/results.json").read_text())["runs"]]
                self.assertEqual(shared, [count > 1] * len(shared))

    def test_a_part_has_its_share_of_the_pieces_once(self):
        self.write(WITH_PICTURES)
        listed = self.list_pieces(5)
        whole = self.truescatter("run", "e.toml", "--dry-run").stdout
        pieces = [line.split()[1].rstrip(":") for line in whole.splitlines() if line.startswith("piece ")]
        self.assertEqual(list(listed), pieces)
        # Of one view and profile the ladder is where the runs are that it reads.
        for view in ("front-01", "front-02", "side-01", "side-02"):
            for profile in ("narrow", "wide"):
                together = {part for piece, part in listed.items() if f".{view}.{profile}" in piece}
                self.assertEqual(len(together), 1, (view, profile))
        self.run_part("2/5")
        self.assertEqual(self.pieces_of("2/5"), sorted(piece for piece, part in listed.items() if part == 2))

    def test_cuts_are_between_views_where_no_part_gets_dearer(self):
        # Four equal views in two equal halves: a third of the cost is a view and a third, and the nearest cuts between
        # halves leave 1.5, 1 and 1.5 views and two views divided. One cut can move: 1, 1.5, 1.5. Runs timed so
        # often that beside them the widths of the ladder's filter cost little; those are of no view.
        text = WITH_PICTURES.replace(STABILITY, "").replace("blur2d", "screen-gaussian")
        self.write(text.replace("px = 16", "px = 64").replace("repeats = 1", "repeats = 10000"))
        for count, divided in ((1, 0), (2, 0), (3, 1), (4, 0), (8, 4)):
            parts_of_views = {}
            for piece, part in self.list_pieces(count).items():
                if not piece.startswith("widths"):
                    parts_of_views.setdefault(piece.split(".")[1], set()).add(part)
            self.assertEqual(sum(len(parts) - 1 for parts in parts_of_views.values()), divided, parts_of_views)

    def test_killed_parts_go_on(self):
        self.run_whole()
        for index in range(1, 4):
            part = f"{index}/3"
            self.kill_at_a_piece(part)
            self.assertIn("pieces are finished", self.run_part(part, "--resume"))
        self.expect_the_same(3)
        # What is finished is not done again.
        self.assertIn("part 2/3 is finished already", self.run_part("2/3", "--resume"))

    def test_eight_at_once_compute_each_truth_once(self):
        self.run_whole()
        computed = self.run_at_once(8)
        self.assertEqual(computed, len(list((self.folder / "cache").glob("*.truth"))))
        self.assertEqual(list((self.folder / "cache").glob(".*.lock")), [])
        self.expect_the_same(8)

    def test_eight_at_once_share_audits_and_light_paths(self):
        self.write(WITH_LIGHT_THROUGH)
        self.run_whole()
        computed = self.run_at_once(8)
        self.assertEqual(computed, len(list((self.folder / "cache").glob("*.truth"))))
        self.expect_the_same(8)

    def test_damaged_truths_are_computed_once(self):
        self.run_part("1/1")
        kept = sorted((self.folder / "cache").glob("*.truth"))
        for file in kept:
            bytes_of = bytearray(file.read_bytes())
            bytes_of[-1] ^= 1
            file.write_bytes(bytes_of)
        self.assertEqual(self.run_at_once(4), len(kept))

    def test_a_claim_of_a_process_that_died_holds_nobody_up(self):
        with self.start("1/1") as process:
            while process.poll() is None and not list((self.folder / "cache").glob(".*.lock")):
                time.sleep(0.0005)
            process.send_signal(signal.SIGKILL)
        self.assertNotEqual(process.returncode, 0)
        self.assertEqual(len(list((self.folder / "cache").glob(".*.lock"))), 1)
        self.assertNotIn("waiting", self.run_part("1/1"))

    def test_what_cannot_be_joined_is_named(self):
        for index in (1, 2, 3):
            self.run_part(f"{index}/3")

        def refused(*parts):
            result = self.merge(*parts)
            self.assertEqual(result.returncode, 2)
            self.assertFalse((self.folder / "merged").exists())
            return result.stderr

        self.assertIn("parts 1, 3 of 3 are missing", refused("parts/2-3"))
        self.assertIn("part 3 of 3 is missing", refused("parts/1-3", "parts/2-3"))
        self.assertIn("part 2/3 is there more than once: parts/2-3, parts/2-3", refused("parts/2-3", "parts/2-3", "parts/1-3"))
        self.assertIn("parts/4-3: no such folder", refused("parts/1-3", "parts/4-3"))
        self.run_part("2/2")
        self.assertIn("not of one division", refused("parts/1-3", "parts/2-2"))
        self.assertIn("has no part.json: it is no result of `run --part`", refused("parts/1-3", "parts"))
        # Another experiment, another version, and a piece that is gone.
        shutil.move(self.folder / "parts/2-3", self.folder / "parts/kept")
        self.write(EXPERIMENT.replace("repeats = 1", "repeats = 2"))
        self.run_part("2/3")
        self.assertIn("parts/2-3/part.json: cannot be joined with parts/1-3: experiment was", refused(*self.parts(3)))
        shutil.rmtree(self.folder / "parts/2-3")
        shutil.move(self.folder / "parts/kept", self.folder / "parts/2-3")
        file = self.folder / "parts/2-3/part.json"
        part = json.loads(file.read_text())
        file.write_text(json.dumps(part | {"provenance": part["provenance"] | {"commit": "other"}}))
        self.assertIn("cannot be joined with parts/1-3: commit was", refused(*self.parts(3)))
        file.write_text(json.dumps(part))
        for index in (1, 2, 3):
            self.change_part(f"parts/{index}-3", lambda read: read["provenance"].update(program="f" * 40))
        self.assertIn("was computed by another program, which alone can merge it: program was", refused(*self.parts(3)))
        for index in (1, 2, 3):
            self.change_part(f"parts/{index}-3", lambda read: read["provenance"].update(program=part["provenance"]["program"]))
        file.write_text(json.dumps(part))
        lost = self.folder / "parts/2-3/pieces" / (part["pieces"][0] + ".json")
        lost.rename(self.folder / "lost.json")
        self.assertIn(f"{part['pieces'][0]}.json: this file of part 2/3 is missing", refused(*self.parts(3)))
        (self.folder / "lost.json").rename(lost)
        picture = next((self.folder / "parts/2-3/maps").glob("*.exr"))
        picture.write_bytes(picture.read_bytes()[:-1])
        self.assertIn(f"{picture.name}: is not the file that part.json says", refused(*self.parts(3)))
        file.write_text("{}")
        self.assertIn("part.json: is not what `run --part` writes", refused(*self.parts(3)))

    def change_part(self, part, change):
        file = self.folder / part / "part.json"
        read = json.loads(file.read_text())
        change(read)
        file.write_text(json.dumps(read))

    def test_parts_are_merged_without_the_experiments_files(self):
        # What results say of a file, of a bound's place and of a sweep over files is what the run would say.
        fit = ["fit", "--profile", "classical-dipole", "--material", "skin1", "--out"]
        for gaussians, name in (("1", "one.json"), ("2", "two.json")):
            made = self.truescatter(*fit, name, "--gaussians", gaussians)
            self.assertEqual(made.returncode, 0, made.stderr)
        profile = """[[profile]]
name = "fitted"
r_max_mm = 6.0
fit.file = "one.json"
of = {model = "classical-dipole", material = "skin1", tolerance = 1e-3}
[[threshold]]
method = "none"
metric = "rel_rmse"
maximum = 1e-4
[[method]]
name = "none"
"""
        text = EXPERIMENT.replace('[[method]]\nname = "none"\n', profile)
        sweep = text[text.index("[sweep]"):text.index("[timing]")]
        self.write(text.replace(sweep, '[sweep]\nkey = "profile.fitted.fit.file"\nvalues = ["one.json", "two.json"]\n'
                                       "axis_values = [1, 2]\n"))
        whole = self.truescatter("run", "e.toml", "--out", "whole", "--no-cache")
        self.assertEqual(whole.returncode, 1, whole.stderr)
        for index in (1, 2, 3):
            self.run_part(f"{index}/3")
        # The resolved experiment names files from wherever it is read.
        again = self.truescatter("run", "parts/1-3/experiment.resolved.toml", "--dry-run")
        self.assertEqual(again.returncode, 0, again.stderr)
        for name in ("e.toml", "one.json", "two.json"):
            (self.folder / name).unlink()
        merged = self.merge(*self.parts(3))
        self.assertEqual(merged.returncode, 1, merged.stderr)
        self.assertEqual([line for line in merged.stderr.splitlines() if line.startswith("exceeded")],
                         [line for line in whole.stderr.splitlines() if line.startswith("exceeded")])
        self.expect_whole("merged")

    def test_times_of_several_machines_are_in_no_chart(self):
        for index in (1, 2):
            self.run_part(f"{index}/2", "--whole-node")
        self.assertEqual(self.merge(*self.parts(2)).returncode, 0)
        results = json.loads((self.folder / "merged/results.json").read_text())
        self.assertNotIn("machines", results["provenance"])
        self.assertEqual([run for run in results["runs"] if run["cost"]["frame_ms"].get("shared")], [])

        def elsewhere(part):
            part["provenance"]["machine"]["cores"] += 1
            part["provenance"]["rasteriser_threads"] += 1

        self.change_part("parts/2-2", elsewhere)
        self.assertEqual(self.merge(*self.parts(2)).returncode, 0)
        results = json.loads((self.folder / "merged/results.json").read_text())
        self.assertEqual(len(results["provenance"]["machines"]), 2)
        self.assertEqual([run for run in results["runs"] if not run["cost"]["frame_ms"].get("shared")], [])

    def test_a_part_goes_on_elsewhere_and_begins_again_when_it_is_of_something_else(self):
        key = self.kill_at_a_piece("1/1") / "key.json"
        before = json.loads(key.read_text())
        before["machine"]["cores"] += 1
        key.write_text(json.dumps(before))
        self.assertIn("pieces are finished", self.run_part("1/1", "--resume"))
        self.assertEqual(self.merge("parts/1-1").returncode, 0)
        results = json.loads((self.folder / "merged/results.json").read_text())
        self.assertEqual(len(results["provenance"]["machines"]), 2)
        shutil.rmtree(self.folder / "parts")
        self.kill_at_a_piece("1/1")

        def said():
            return self.truescatter("run", "e.toml", "--part", "1/1", "--dry-run", "--out", "parts/1-1").stdout

        self.assertIn("finished by a run that was cut off, --resume takes it over", said())
        self.write(EXPERIMENT.replace("repeats = 1", "repeats = 2"))
        self.assertIn("of another program, experiment or input, which --resume cannot use", said())
        self.assertIn("what was cut off is of something else (experiment was", self.run_part("1/1", "--resume"))

    def test_a_part_is_finished_when_it_is_what_is_asked_for(self):
        def again(*arguments):
            return self.run_part("1/2", "--resume", *arguments)

        def said():
            dry = self.truescatter("run", "e.toml", "--part", "1/2", "--dry-run", "--out", "parts/1-2")
            self.assertEqual(dry.returncode, 0, dry.stderr)
            return {line.split("; ")[1] for line in dry.stdout.splitlines() if line.startswith("piece ")}

        self.assertEqual(said(), {"nothing of it is kept"})
        again()
        self.assertEqual(said(), {"finished in the part that is there, --resume leaves it"})
        self.assertIn("part 1/2 is finished already", again())
        self.assertNotIn("finished already", again("--whole-node"))
        self.assertNotIn("finished already", again("--whole-node", "--buffers"))
        self.assertIn("finished already", again("--whole-node", "--buffers"))
        next((self.folder / "parts/1-2/maps").glob("*.exr")).unlink()
        self.assertNotIn("finished already", again("--whole-node", "--buffers"))
        self.change_part("parts/1-2", lambda read: read.pop("files"))
        self.assertIn("computing the part again", again("--whole-node", "--buffers"))

    def test_nothing_finished_is_overwritten(self):
        self.run_part("1/1")
        for out in ("parts/1-1", "parts/1-1/inner", "parts"):
            refused = self.truescatter("merge", "parts/1-1", "--out", out)
            self.assertEqual(refused.returncode, 2, out)
            self.assertIn("is, holds or lies in parts/1-1, a part that is to be merged", refused.stderr)
        whole = self.truescatter("run", "e.toml", "--out", "parts/1-1")
        self.assertEqual(whole.returncode, 2)
        self.assertIn("parts/1-1: holds a part of an experiment, which a whole result does not replace", whole.stderr)
        self.assertEqual(self.merge("parts/1-1").returncode, 0)
        part = self.truescatter("run", "e.toml", "--part", "1/2", "--out", "merged")
        self.assertEqual(part.returncode, 2)
        self.assertIn("merged: holds a whole result, which a part does not replace", part.stderr)

    def test_slurm_run_hands_on_what_it_is_given(self):
        self.run_whole()
        tools = self.folder / "tools"
        tools.mkdir()
        for name, text in (("sbatch", SBATCH), ("squeue", '#!/bin/sh\ncat "$SQUEUE"\n')):
            (tools / name).write_text(text)
            (tools / name).chmod(0o755)
        (self.folder / "queue").write_text("")
        environment = self.environment | {
            "PATH": f"{tools}:{os.environ['PATH']}", "SLURM_CPUS_PER_TASK": "1", "SQUEUE": str(self.folder / "queue"),
            "SBATCH_ARGUMENTS": str(self.folder / "arguments")}
        command = [ROOT / "scripts/slurm-run", "e.toml", "2", "--out", "a result", "--program", PROGRAM, "--whole-node",
                   "--sbatch", "--cpus-per-task=1", "--", "--jobs", "1"]

        def submit():
            return subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True)

        done = submit()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"truths: shared by {self.folder / 'cache'}", done.stdout)
        arguments = (self.folder / "arguments").read_text().splitlines()
        self.assertEqual(arguments.count("--exclusive"), 1)
        self.assertEqual(arguments.count("--cpus-per-task=1"), 2)
        self.expect_whole("a result")
        self.assertEqual(submit().returncode, 0)
        self.assertIn("part 2/2 is finished already", (self.folder / "a result.parts/2.log").read_text())
        # While the array is there, and where the result cannot be.
        (self.folder / "queue").write_text("7 all tiny root R\n")
        refused = submit()
        self.assertEqual(refused.returncode, 2)
        self.assertIn("job 7, which computes these parts, is still there", refused.stderr)
        (self.folder / "queue").write_text("")
        (self.folder / "a result/notes.txt").write_text("mine")
        self.assertIn("holds 'notes.txt', which is no result of truescatter", submit().stderr)

    def test_no_part_is_refused(self):
        for part in ("0/3", "4/3", "3", "a/b", "1/0", "-1/2"):
            result = self.truescatter("run", "e.toml", f"--part={part}")
            self.assertEqual(result.returncode, 2, part)
            self.assertIn("--part: ", result.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[2:]])
