"""The chart of a grid of settings, in Chromium with every name lookup failing.

    grid_in_browser.py FOLDER [TEST...]

FOLDER holds what `run` made of grid.toml. Exit codes: 0 good, 1 a test failed, 77 no browser.
"""

import json
import pathlib
import sys
import tempfile
import unittest

from devtools import Browser, Page, find_browser, page_without_plotly

FOLDER = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None


BROWSER = None  # of all tests: starting one takes longer than most of them


def setUpModule():
    global BROWSER
    BROWSER = unittest.enterModuleContext(Browser(find_browser()))


class GridInBrowser(unittest.TestCase):
    def setUp(self):
        self.results = json.loads((FOLDER / "results.json").read_text())
        self.page = self.enterContext(Page(BROWSER, (FOLDER / "report.html").as_uri()))
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

    # {axis: [(name, error in percent, cost, hover text)]} of the points that the charts show.
    def points(self, axis):
        chart = f".pareto[data-axis={axis}]"
        self.page.chart(chart)
        return self.page.evaluate(f"""document.querySelector("{chart}").data.filter((t) => t.mode === "markers")
          .flatMap((t) => t.x.map((x, i) => [t.text[i].split("<br>")[0], t.y[i], x, t.text[i]]))""")

    def test_one_chart_holds_every_setting(self):
        self.assertEqual(self.page.evaluate("document.querySelectorAll('.pareto-card').length"), 1)
        paid = {name: (error, costs) for name, error, costs in self.settings() if costs["time"] > 0}
        self.assertEqual(len(paid), 16)
        if not self.page.evaluate("hasPlotly"):
            self.assertEqual(self.page.evaluate("document.querySelectorAll('[data-axis=time] .marker').length"), 16)
            return
        for axis in ("time", "fetches", "bytes"):
            points = self.points(axis)
            self.assertEqual(sorted(name for name, *_ in points), sorted(paid))
            for name, error, cost, _ in points:
                # The same numbers, but for the rounding of their products.
                self.assertAlmostEqual(error, 100 * paid[name][0], delta=1e-12 * error)
                self.assertAlmostEqual(cost, paid[name][1][axis], delta=1e-12 * cost)

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
        names = {name for name, _, costs in self.settings() if costs["time"] > 0}
        if self.page.evaluate("hasPlotly"):
            tips = [tip for *_, tip in self.points("time")]
        else:
            tips = self.page.evaluate("[...document.querySelectorAll('[data-axis=time] .marker')].map((m) => m.dataset.tip)")
        self.assertEqual({tip.replace("<br>", "\n").split("\n")[0] for tip in tips}, names)
        for tip in tips:
            self.assertIn("settings: ", tip)

    def test_without_plotly_the_charts_are_plain_and_say_so(self):
        paid = sum(1 for setting in self.settings() if setting[2]["time"] > 0)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "report.html")
            path.write_text(page_without_plotly(FOLDER / "report.html"))
            with Page(BROWSER, path.as_uri()) as page:
                page.wait_for("document.documentElement.dataset.values")
                for axis in ("time", "fetches", "bytes"):
                    self.assertEqual(page.evaluate(f"document.querySelectorAll('svg[data-axis={axis}] .marker').length"), paid)
                self.assertIn("plain SVG", page.evaluate("document.querySelector('#speed .chart-note').textContent"))
                self.assertEqual(page.evaluate("document.querySelectorAll('.plot').length"), 0)
                # A click on a marker shows its pictures, as plotly's does.
                page.evaluate("document.querySelector('svg[data-axis=time] .marker').dispatchEvent(new MouseEvent('click'))")
                tip = page.evaluate("document.querySelector('svg[data-axis=time] .marker').dataset.tip")
                self.assertTrue(tip.startswith(page.evaluate("viewerState.right") + ","))
                self.assertEqual(page.complaints, [])

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
