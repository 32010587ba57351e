"""What the documentation shows is what the program reads.

    experiments_test.py PROGRAM

Every experiment of experiments/ passes a dry run, but for those whose files are not in the repository: the scanned
head's without TRUESCATTER_DATA, and own-image.toml, whose pictures another program makes (it has a test of its own).
README.md shows experiments/first.toml as it is.
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()


class Experiments(unittest.TestCase):
    def test_each_passes_a_dry_run(self):
        files = sorted((ROOT / "experiments").rglob("*.toml"))
        self.assertGreater(len(files), 30)
        for file in files:
            if "${TRUESCATTER_DATA}" in file.read_text() and "TRUESCATTER_DATA" not in os.environ:
                continue
            if file.name == "own-image.toml":
                continue
            with self.subTest(file.name), tempfile.TemporaryDirectory() as folder:
                done = subprocess.run([PROGRAM, "run", file, "--dry-run"], cwd=folder, capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(list(pathlib.Path(folder).iterdir()), [])

    def test_the_readme_explains_the_first(self):
        readme = (ROOT / "README.md").read_text()
        self.assertIn("```toml\n" + (ROOT / "experiments/first.toml").read_text() + "```\n", readme)


if __name__ == "__main__":
    unittest.main()
