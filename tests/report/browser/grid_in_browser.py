"""The chart of a grid of settings, in Chromium with every name lookup failing.

    grid_in_browser.py FOLDER [TEST...]

FOLDER holds what `run` made of grid.toml. Exit codes: 0 good, 1 a test failed, 77 no browser.
"""

import json
import pathlib
import sys
import unittest

from devtools import Page, find_browser

FOLDER = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None


class GridInBrowser(unittest.TestCase):
    def setUp(self):
        self.results = json.loads((FOLDER / "results.json").read_text())
        self.page = self.enterContext(Page(find_browser(), (FOLDER / "report.html").as_uri()))
        self.page.wait_for("document.documentElement.dataset.values")

    def tearDown(self):
        self.assertEqual(self.page.complaints, [])
        self.assertIsNone(self.page.evaluate("document.documentElement.dataset.error ?? null"))

    # [(name, error, {axis: cost})], by their definitions; a setting is a run.
    def settings(self):
        pixels = {view["name"]: view["skin_pixels"] for view in self.results["views"]}
        sizes = {view["name"]: f"{view['width_px']}\u00d7{view['height_px']}" for view in self.results["views"]}
        gaussians = {"one": "1 Gaussian", "two": "2 Gaussians"}
        found = []
        for run in self.results["runs"]:
            cost, share = run["cost"], pixels[run["view"]] / pixels["full"]
            free = cost["passes"] == 0
            found.append((f"{run['label']}, {gaussians[run['profile']]}, {sizes[run['view']]}",
                          run["profile_error"]["metrics"]["rel_rmse"],
                          {"time": 0 if free else cost["frame_ms"]["median"],
                           "fetches": 0 if free else share * cost["fetches_per_pixel"],
                           "bytes": 0 if free else share * cost["bytes_per_pixel"]}))
        return found

    # What no other setting beats: none errs less, or costs less, and is no worse in the other; of two alike the first.
    def front(self, axis):
        found = [(error, costs[axis], i, name) for i, (name, error, costs) in enumerate(self.settings())]
        beats = lambda b, a: b[0] <= a[0] and b[1] <= a[1] and (b[:2] != a[:2] or b[2] < a[2])
        return {a[3] for a in found if not any(beats(b, a) for b in found)}

    def test_one_chart_holds_every_setting(self):
        self.assertEqual(self.page.evaluate("document.querySelectorAll('.pareto-card').length"), 1)
        paid = sum(1 for setting in self.settings() if setting[2]["time"] > 0)
        self.assertEqual(paid, 16)
        for axis in ("time", "fetches", "bytes"):
            self.assertEqual(self.page.evaluate(f"document.querySelectorAll('[data-axis={axis}] .marker').length"), paid)

    # A setting is a method under a sum in a frame, weighed against the profile itself, as `advise` takes it.
    def test_opens_with_the_cheapest_setting(self):
        paid = sorted((costs["time"], name, error) for name, error, costs in self.settings() if costs["time"] > 0)
        free = min(error for _, error, costs in self.settings() if costs["time"] == 0)
        limit = 0.5 * (free + min(error for _, _, error in paid))
        time, name, error = next(setting for setting in paid if setting[2] <= limit)
        self.page.evaluate(f"setThreshold({limit})")
        sentence = self.page.evaluate("document.querySelector('#verdict').textContent.replace(/\\u202f/g, ' ')")
        self.assertTrue(sentence.startswith(f"{name} is the cheapest method within "), sentence)
        shown = float(sentence.split(", at ")[1].split(" %")[0])
        self.assertAlmostEqual(shown, 100 * error, delta=0.5 * error)
        self.assertIn("against the profile itself", sentence)

    def test_the_fronts_are_those_of_the_results(self):
        for axis in ("time", "fetches", "bytes"):
            shown = self.page.evaluate(f"[...document.querySelectorAll('.fronts [data-front={axis}]')].map((cell) => "
                                       "cell.parentElement.querySelector('th').textContent.trim())")
            self.assertEqual(set(shown), self.front(axis), axis)
            self.assertEqual(len(shown), len(set(shown)))

    def test_a_marker_says_its_setting(self):
        tips = self.page.evaluate("[...document.querySelectorAll('[data-axis=time] .marker')].map((m) => m.dataset.tip)")
        names = {name for name, _, costs in self.settings() if costs["time"] > 0}
        self.assertEqual({tip.split("\n")[0] for tip in tips}, names)
        for tip in tips:
            self.assertIn("settings: ", tip)

    def test_a_sentence_counts_what_the_fronts_share(self):
        sentence = self.page.evaluate("document.querySelector('.fronts-sentence').textContent")
        time, work = self.front("time"), self.front("fetches")
        if time == work:
            self.assertEqual(sentence, "The fronts by time and by fetches hold the same settings.")
        else:
            self.assertTrue(sentence.startswith(f"By time the front holds {len(time)} settings, by fetches {len(work)}; "
                                                f"{len(time & work)} are on both."), sentence)


if __name__ == "__main__":
    if FOLDER is None:
        sys.exit(__doc__)
    if not find_browser():
        print("skipped: no browser (Debian: apt-get install chromium)")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
