"""What a reader of a report does, done in Chromium with every name lookup failing.

    report_in_browser.py FOLDER [TEST...]

FOLDER holds what `run` made of ball.toml. TRUESCATTER_PICTURES names a folder for screenshots to look at.
Exit codes: 0 good, 1 a test failed, 77 no browser.
"""

import json
import math
import os
import pathlib
import struct
import sys
import unittest
import zlib

import exr
from devtools import Browser, Page, find_browser

FOLDER = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None
LUMINANCE = {"R": 0.2126, "G": 0.7152, "B": 0.0722}


def number_of(text):
    return float(text.replace("\u2212", "-").replace("\u202f", ""))


def png_colours(png):
    """The pixels of an 8-bit PNG of three or four channels, as a set."""
    width, height, depth, colour = struct.unpack_from(">IIBB", png, 16)
    assert depth == 8 and colour in (2, 6)
    size, data, at = (3 if colour == 2 else 4), b"", 8
    while at < len(png):
        (length,) = struct.unpack_from(">I", png, at)
        if png[at + 4:at + 8] == b"IDAT":
            data += png[at + 8:at + 8 + length]
        at += 12 + length
    data, stride, above, colours = zlib.decompress(data), width * size, bytes(width * size), set()
    for y in range(height):
        kind, row = data[y * (stride + 1)], bytearray(data[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left, up = (row[i - size] if i >= size else 0), above[i]
            corner = above[i - size] if i >= size else 0
            nearest = min((abs(up - corner), 0, left), (abs(left - corner), 1, up),
                          (abs(left + up - 2 * corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, up, (left + up) // 2, nearest)[kind]) & 255
        colours.update(bytes(row[i:i + 3]) for i in range(0, stride, size))
        above = row
    return colours


BROWSER = None  # of all tests: starting one takes longer than most of them


def setUpModule():
    global BROWSER
    BROWSER = unittest.enterModuleContext(Browser(find_browser()))


class ReportInBrowser(unittest.TestCase):
    state = ""

    def setUp(self):
        self.results = json.loads((FOLDER / "results.json").read_text())
        self.page = self.enterContext(Page(BROWSER, (FOLDER / "report.html").as_uri() + self.state))
        self.page.wait_for("document.documentElement.dataset.values")

    def tearDown(self):
        self.assertEqual(self.page.complaints, [])
        self.assertIsNone(self.page.evaluate("document.documentElement.dataset.error ?? null"))

    # The methods by the luminance's relative RMSE, as number keys count them.
    def methods(self):
        runs = sorted(self.results["runs"], key=lambda run: run["metrics"]["rel_rmse"])
        return [run["label"] for run in runs]

    def large(self):
        return self.page.box("#viewer .pane.large")

    # Points at the middle of a pixel of the large picture, whole in its pane.
    def point_at(self, x, y):
        view = self.results["views"][0]
        left, top, width, height = self.large()
        self.page.mouse("mouseMoved", left + (x + 0.5) / view["width_px"] * width,
                        top + (y + 0.5) / view["height_px"] * height)

    def shown(self, name):
        return self.page.evaluate(f"document.querySelector('[data-value=\"{name}\"]').lastChild.textContent")

    def test_asks_the_network_for_nothing(self):
        loaded = self.page.evaluate("performance.getEntriesByType('resource').map((e) => e.name)")
        self.assertEqual([name for name in loaded if not name.startswith("blob:")], [])
        self.assertEqual(self.page.complaints, [])
        # The block itself holds: a request fails.
        self.assertEqual(self.page.evaluate("fetch('http://example.org/').then(() => 'came', () => 'failed')"), "failed")
        self.page.complaints.clear()

    def test_says_what_is_seen(self):
        runs = {run["label"]: run for run in self.results["runs"]}
        words = self.page.evaluate("document.getElementById('words').textContent")
        said = words.split("In the final picture")[1]
        unseen = [label for label, run in runs.items() if run["metrics"]["visible"]["p95"] <= 0.05]
        for label in runs:
            # Those that pass for the truth are named before "cannot", the others after it.
            self.assertEqual(said.find(label) < said.find("cannot be told"), label in unseen, label)
        error = {label: run["metrics"]["rel_rmse"] for label, run in runs.items()}
        seen = [label for label in runs if label not in unseen]
        if seen and unseen:
            least, most = min(seen, key=error.get), max(unseen, key=error.get)
            self.assertIn(f"The least error that is seen is {least}", said)
            self.assertIn(f"the largest that is not, {most}", said)
        column = self.page.evaluate("1 + COLUMNS.findIndex((column) => columnKey(column) === 'Seen.p95')")
        rows = self.page.evaluate(f"""[...document.querySelector('#metrics table.metrics').tBodies[0].rows].map(
            (tr) => [tr.cells[0].textContent.trim(), Number(tr.cells[{column}].dataset.value)])""")
        self.assertEqual(dict(rows), {label: run["metrics"]["visible"]["p95"] for label, run in runs.items()})
        pictures = self.page.evaluate("[...document.querySelectorAll('.column img')].map((img) => img.alt)")
        for label in runs:
            self.assertIn(f"{label}, as seen", pictures)
            self.assertIn(f"{label}, visible difference", pictures)

    def test_opens_with_a_sentence_that_the_results_bear_out(self):
        opening = "document.querySelector('#verdict').textContent.replace(/\\u202f/g, ' ')"
        runs = {run["label"]: run for run in self.results["runs"]}
        error = {label: 100 * run["metrics"]["rel_rmse"] for label, run in runs.items()}
        least, most = min(error, key=error.get), max(error, key=error.get)
        self.page.evaluate(f"setThreshold({0.005 * error[least]})")
        sentence = self.page.evaluate(opening)
        self.assertTrue(sentence.startswith("No method stays within "), sentence)
        self.assertIn(f"the nearest is {least}; it is worst in front", sentence)
        self.assertAlmostEqual(float(sentence.split(" at ")[1].split(" %")[0]), error[least], delta=0.005 * error[least])
        paid = {label: run["cost"]["frame_ms"]["median"] for label, run in runs.items() if run["cost"]["passes"] > 0}
        free = next(label for label in runs if label not in paid)
        self.page.evaluate(f"setThreshold({0.0101 * error[most]})")
        self.assertTrue(self.page.evaluate(opening).startswith(f"{free} is the cheapest method within "))
        within = [label for label in paid if error[label] < error[free]]
        self.page.evaluate(f"setThreshold({0.00999 * error[free]})")
        self.assertTrue(within)
        cheapest = min((label for label in within if error[label] <= 0.999 * error[free]), key=paid.get)
        self.assertTrue(self.page.evaluate(opening).startswith(f"{cheapest} is the cheapest method within "))

    def test_names_the_costliest_assumption_up_to_the_method_it_names(self):
        opening = "document.querySelector('#verdict').textContent.replace(/\\u202f/g, ' ')"
        error = {run["label"]: run["metrics"]["rel_rmse"] for run in self.results["runs"]}
        rungs = self.results["ladders"][0]["rungs"]
        labels = [rung["rung"] for rung in rungs]
        until = rungs[1:labels.index("pscbf") + 1]
        costliest = max(until, key=lambda rung: rung["step"]["rmse"])
        # The step after it is larger, so that taking all of the ladder would show.
        self.assertGreater(rungs[-1]["step"]["rmse"], costliest["step"]["rmse"])
        self.assertEqual(min(error, key=error.get), "pscbf")
        self.page.evaluate(f"setThreshold({1.0001 * error['pscbf']})")
        sentence = self.page.evaluate(opening)
        self.assertTrue(sentence.startswith("pscbf is the cheapest method within "), sentence)
        self.assertIn(f"the assumption that costs it most is \u201c{costliest['assumption']}\u201d", sentence)
        self.page.evaluate("setThreshold(1e6)")
        self.assertIn("it assumes that light leaves where it came in", self.page.evaluate(opening))

    # What the page says of a method on no ladder follows from its error against its own target.
    def test_without_a_ladder_weighs_the_aim_of_a_method(self):
        says = lambda left, error, truth: self.page.evaluate(f"""costliestAssumption("off-ladder", {{
            c: cases[0], run: {{cost: {{passes: 1}}, truth: "headline", metrics: {{rel_rmse: {error}}}, own_target: {{
              metric: "geodesic", normalised: true, r_max_mm: null, truth: "{truth}", metrics: {{rel_rmse: {left}}}}}}}}})
            .replace(/\\u202f/g, ' ')""")
        self.assertEqual(says(0.01, 0.04, "own"),
                         "the assumption that costs it most is its aim (geodesic, normalised): against that it is "
                         "off by 1.00 %")
        self.assertTrue(says(0.039, 0.04, "own").startswith("its aim (geodesic, normalised) costs it little: "))
        self.assertTrue(says(0.03, 0.04, "own").startswith("its aim (geodesic, normalised) is a part of it: "))
        self.assertIn("was not measured", says(0.04, 0.04, "headline"))

    def test_number_keys_flip_between_methods(self):
        for key, label in enumerate(self.methods(), start=1):
            self.page.key(str(key), f"Digit{key}")
            self.assertEqual(self.page.evaluate("document.querySelector('.large .tag.right').textContent"), label)
            self.assertEqual(self.page.evaluate("viewerState.split"), 0)
            picture = f"maps/front.spike-and-base.{label}.png"
            self.assertTrue(self.page.evaluate(
                f"document.querySelector('.large .layer img').src === pictureUrl({json.dumps(picture)})"))

    def test_shift_shows_the_truth_while_held(self):
        visible = "getComputedStyle(document.querySelector('.large .held')).display !== 'none'"
        self.assertFalse(self.page.evaluate(visible))
        self.page.key("Shift", "ShiftLeft", ("keyDown",))
        self.assertTrue(self.page.evaluate(visible))
        self.page.key("Shift", "ShiftLeft", ("keyUp",))
        self.assertFalse(self.page.evaluate(visible))

    def test_zooms_every_picture_alike(self):
        left, top, width, height = self.large()
        self.page.evaluate("document.querySelector('.pane.large').focus()")
        self.page.key("+")
        scales = self.page.evaluate("""[...document.querySelectorAll('#viewer .pane > .layer img, #viewer .tile img')]
          .filter((img) => img.getBoundingClientRect().width > 0)
          .map((img) => img.getBoundingClientRect().width / img.closest('.pane').getBoundingClientRect().width)""")
        self.assertGreater(len(scales), 3)
        for scale in scales:
            self.assertAlmostEqual(scale, 1.5, delta=0.02)  # the pane's and the picture's widths are whole pixels
        self.page.key("0")
        self.assertEqual(self.page.evaluate("viewerState.zoom"), 1)

    def test_values_under_the_pointer_are_those_of_the_exr(self):
        label = self.methods()[0]
        self.page.key("1", "Digit1")
        stated = self.page.evaluate("caseValues(cases[0]).then((v) => [v.truth.error, v.runs.get(%s).error])"
                                    % json.dumps(label))
        files = [("truth", "truth", stated[0]), (label, label, stated[1])]
        for name, stem, error in files:
            width, height, channels = exr.read(FOLDER / f"maps/front.spike-and-base.{stem}.exr")
            self.assertLess(error, 1e-4)
            for x, y in ((48, 40), (60, 30), (40, 20), (55, 62)):
                self.assertGreater(channels["mask"][y * width + x], 0)
                self.point_at(x, y)
                self.assertEqual(self.shown("x, y"), f"{x}, {y}")
                luminance, colours = self.shown(name).rstrip(")").split(" (")
                expected = [channels[c][y * width + x] for c in "RGB"]
                # Five digits are shown: half a unit of the last is at most 5e-5 of the value.
                for text, value in zip(colours.split("  "), expected, strict=True):
                    self.assertAlmostEqual(number_of(text), value, delta=error + 5e-5 * abs(value))
                whole = sum(w * channels[c][y * width + x] for c, w in LUMINANCE.items())
                self.assertAlmostEqual(number_of(luminance), whole, delta=error + 5e-5 * abs(whole))
        self.point_at(1, 1)
        self.assertEqual(self.shown(label), "not measured")

    def test_statistics_of_the_whole_picture_are_those_of_the_run(self):
        for run in self.results["runs"]:
            found = self.page.evaluate("caseValues(cases[0]).then((v) => ({...regionStatistics(v.truth, "
                                       "v.runs.get(%s), WHOLE, 'luminance'), steps: v.truth.error + v.runs.get(%s).error}))"
                                       % (json.dumps(run["label"]), json.dumps(run["label"])))
            self.assertEqual(found["pixels"], run["metrics"]["pixels"])
            # Each error is off by at most both roundings, and so are their mean, root of mean square and largest.
            for name in ("bias", "rmse", "max"):
                self.assertAlmostEqual(found[name], run["metrics"][name], delta=found["steps"])

    def test_a_dragged_region_has_its_own_statistics(self):
        label = self.methods()[0]
        self.page.key("1", "Digit1")
        self.page.key("r", "KeyR")
        left, top, width, height = self.large()
        place = lambda x, y: (left + x / 96 * width, top + y / 80 * height)
        self.page.drag(*place(40, 32), *place(60, 52))
        self.page.wait_for("document.querySelector('.region-facts h4').textContent.startsWith('Columns')")
        region = self.page.evaluate("viewerState.region")
        edges = [round(region[e] * n) for e, n in (("x0", 96), ("x1", 96), ("y0", 80), ("y1", 80))]
        for edge, wanted in zip(edges, (40, 60, 32, 52), strict=True):
            self.assertLessEqual(abs(edge - wanted), 1)  # the pointer's place is in whole screen pixels
        _, _, truth = exr.read(FOLDER / "maps/front.spike-and-base.truth.exr")
        _, _, test = exr.read(FOLDER / f"maps/front.spike-and-base.{label}.exr")
        errors = [sum(w * (test[c][y * 96 + x] - truth[c][y * 96 + x]) for c, w in LUMINANCE.items())
                  for y in range(edges[2], edges[3]) for x in range(edges[0], edges[1])]
        cells = self.page.evaluate("[...document.querySelectorAll('.region-facts tbody tr')].map((row) => "
                                   "[...row.children].map((cell) => cell.textContent))")
        row = next(cells_of for cells_of in cells if cells_of[0] == label)
        self.assertEqual(int(number_of(row[1])), len(errors))
        for text, value in ((row[2], sum(errors) / len(errors)),
                            (row[3], math.sqrt(sum(e * e for e in errors) / len(errors))),
                            (row[5], max(abs(e) for e in errors))):
            self.assertAlmostEqual(number_of(text), value, delta=1e-4)  # two roundings of below 5e-5 each
        bars = self.page.evaluate("[...document.querySelectorAll('.histogram [data-tip]')].map((b) => "
                                  "parseInt(b.dataset.tip.replace(/\\u202f/g, '')))")
        self.assertEqual(sum(bars), len(errors))

    def test_tables_sort_by_a_click_on_their_heads(self):
        order = "[...document.querySelectorAll('.case-table table.metrics:not(.ladder) tbody th')].map((th) => th.textContent.trim())"
        button = "document.querySelector('th[data-sort=\"Error.max\"] button').click()"
        by_max = [run["label"] for run in sorted(self.results["runs"], key=lambda run: run["metrics"]["max"])]
        self.page.evaluate(button)
        self.assertEqual(self.page.evaluate(order), by_max)
        self.page.evaluate(button)
        self.assertEqual(self.page.evaluate(order), by_max[::-1])
        self.assertEqual(self.page.evaluate(
            "document.querySelector('th[data-sort=\"Error.max\"]').getAttribute('aria-sort')"), "descending")

        self.page.evaluate(button)
        self.assertEqual(self.page.evaluate(order), self.methods())

    def test_the_first_table_sorts_by_the_keyboard(self):
        order = "[...document.querySelectorAll('.matrix tbody th')].map((th) => th.textContent.trim())"
        self.page.evaluate("document.querySelectorAll('.matrix thead button')[1].focus()")
        sort = "document.querySelectorAll('.matrix thead th')[1].getAttribute('aria-sort')"
        self.assertIsNone(self.page.evaluate(sort))
        for wanted, name in ((self.methods(), "ascending"), (self.methods()[::-1], "descending")):
            self.page.call("Input.dispatchKeyEvent", {"type": "keyDown", "key": "Enter", "code": "Enter", "text": "\r",
                                                      "windowsVirtualKeyCode": 13})
            self.page.call("Input.dispatchKeyEvent", {"type": "keyUp", "key": "Enter", "code": "Enter"})
            self.assertEqual(self.page.evaluate(order), wanted)
            self.assertEqual(self.page.evaluate(sort), name)

    def test_every_table_of_more_than_two_rows_sorts(self):
        found = self.page.evaluate("""[...document.querySelectorAll("table")].filter((t) => t.tBodies[0].rows.length > 2)
          .map((t) => [t.className, t.tHead.querySelectorAll("th[data-sort] button").length, t.tBodies[0].rows[0].cells.length])""")
        self.assertGreater(len(found), 2)
        for name, heads, cells in found:
            self.assertEqual(heads, cells, name)

    def test_shown_numbers_sort_by_what_they_say(self):
        for text, value in (("2.5\u202f\u00d7\u202f10\u207b\u2075", 2.5e-5), ("10\u207b\u00b3", 1e-3), ("\u22121.5 %", -1.5),
                            ("12\u202f345", 12345), ("<0.0001", 0.0001), ("10", 10), ("\u2013", None), ("none", "none")):
            self.assertEqual(self.page.evaluate(f"sortValue(h('td', {{}}, {json.dumps(text)}))"), value, text)

    def test_stretch_has_the_errors_of_the_results(self):
        rows = self.page.evaluate("[...document.querySelectorAll('table.stretch tbody tr')].map((row) => "
                                  "[...row.querySelectorAll('th, td')].map((cell) => cell.textContent.trim()))")
        self.assertEqual([row[0] for row in rows], [run["label"] for run in self.results["runs"]])
        for row, run in zip(rows, self.results["runs"]):
            bins = [b for b in run["metrics"]["seam"]["stretch"] if b["pixels"] > 0]
            self.assertEqual(len(row), 1 + len(bins))
            for text, b in zip(row[1:], bins):
                # Three digits are shown.
                self.assertAlmostEqual(number_of(text.rstrip("%")), 100 * b["rel_rmse"], delta=0.5e-2 * 100 * b["rel_rmse"])

    def rest(self):
        self.page.wait_for("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")

    # Of the first halo chart: each method's error by bin, as plotly was given it; asinh there makes room.
    def test_halo_charts_hold_the_profiles_of_the_results(self):
        if not self.page.evaluate("hasPlotly"):
            self.skipTest("built without plotly.js")
        self.page.chart(".halo-row .halo")
        traces = self.page.evaluate("document.querySelector('.halo-row .halo').data.map((t) => [t.name, t.x, t.y])")
        self.assertEqual([name for name, *_ in traces], [run["label"] for run in self.results["runs"]])
        for (_, xs, ys), run in zip(traces, self.results["runs"], strict=True):
            profile = run["metrics"]["halo"]["profile"]
            wanted = [((i + 0.5) * profile["bin_mm"], error)
                      for i, error in enumerate(profile["relative_error"]) if profile["pixels"][i] > 0]
            self.assertEqual(len(xs), len(wanted))
            for x, y, (delta, error) in zip(xs, ys, wanted, strict=True):
                self.assertAlmostEqual(x, delta, delta=1e-12 * delta)
                if error is None:
                    self.assertIsNone(y)
                else:
                    self.assertAlmostEqual(math.sinh(y), 100 * error, delta=1e-9 * (1 + abs(100 * error)))

    def test_charts_tell_their_values_on_hover(self):
        if self.page.evaluate("hasPlotly"):
            x, y, width, height = self.page.chart(".halo-row .halo")
            self.rest()
            self.page.mouse("mouseMoved", x + 0.5 * width, y + 0.5 * height)
            tip = self.page.wait_for("document.querySelector('.halo-row .halo .hoverlayer .legend')?.textContent")
            self.assertIn("\u03b4 ", tip)
        else:
            x, y, width, height = self.page.box(".halo-row .strip")
            self.rest()
            self.page.mouse("mouseMoved", x + width / 2, y + height / 2)
            tip = self.page.wait_for("document.querySelector('.tip:not([hidden])')?.textContent")
        for label in self.methods():
            self.assertIn(label + "  ", tip.replace("\u00a0", " "))

    def test_a_point_of_a_chart_says_its_error_and_shows_its_pictures(self):
        if not self.page.evaluate("hasPlotly"):
            self.skipTest("built without plotly.js")
        self.page.chart(".scatter")
        self.rest()
        run = next(run for run in self.results["runs"] if run["cost"]["passes"] > 0)
        places = self.page.evaluate("""[...document.querySelectorAll('.scatter')][0].data
          .map((t, i) => [t.name, [...document.querySelectorAll('.scatter .scatterlayer')][0].children[i]
          .querySelector('.point')?.getBoundingClientRect()]).filter(([, box]) => box)
          .map(([name, box]) => [name, box.left + box.width / 2, box.top + box.height / 2])""")
        _, x, y = next(place for place in places if place[0] == run["label"])
        self.page.mouse("mouseMoved", x, y)
        tip = self.page.wait_for("document.querySelector('.scatter .hoverlayer .hovertext')?.textContent")
        self.assertTrue(tip.startswith(run["label"]), tip)
        shown = number_of(tip.split("error ")[1].split("\u202f%")[0])
        # Three digits are shown.
        self.assertAlmostEqual(shown, 100 * run["metrics"]["rel_rmse"], delta=0.5 * run["metrics"]["rel_rmse"])
        self.page.click(x, y)
        self.page.wait_for(f"viewerState.right === {json.dumps(run['label'])}")

    def test_paper_has_every_chart_in_the_light_colours(self):
        if not self.page.evaluate("hasPlotly"):
            self.skipTest("built without plotly.js")
        self.page.evaluate("setTheme('dark')")
        self.page.evaluate("addEventListener('beforeprint', () => (window.printed = [...document.querySelectorAll('.plot')]"
                           ".map((c) => c.querySelector('.xtitle')?.style.fill)))")
        self.page.call("Page.printToPDF", {})
        fills = self.page.evaluate("printed")
        self.assertGreater(len(fills), 2)
        self.assertEqual(set(fills), {"rgb(51, 51, 51)"})  # --soft of the light theme
        self.assertEqual(self.page.evaluate("document.documentElement.dataset.theme"), "dark")

    def test_a_question_mark_names_the_keys(self):
        self.page.key("?", "Slash")
        self.assertIn("Shift", self.page.evaluate("document.querySelector('dialog[open]').textContent"))
        self.page.key("Escape", "Escape", ("rawKeyDown", "keyUp"))

    def test_screenshots_show_the_page_light_and_dark(self):
        pictures = os.environ.get("TRUESCATTER_PICTURES")
        self.large()
        for theme in ("light", "dark"):
            self.page.evaluate(f"setTheme('{theme}')")
            png = self.page.screenshot()
            if pictures:
                pathlib.Path(pictures, f"report-{theme}.png").write_bytes(png)
            colours = png_colours(png)
            # Text, pictures and colour maps: an empty or a plain page has a few dozen at most.
            self.assertGreater(len(colours), 500)
            ground = self.page.evaluate("getComputedStyle(document.body).backgroundColor")
            wanted = {"light": "rgb(246, 247, 248)", "dark": "rgb(22, 24, 27)"}[theme]
            self.assertEqual(ground, wanted)
            self.assertIn(bytes(map(int, wanted[4:-1].split(", "))), colours)


class SavedState(ReportInBrowser):
    """The address of a page shows the same again."""
    state = "#view=front&method=none&as=false&zoom=2&x=-0.5&y=-0.25&exposure=1&channel=g&sort=-Error.max&theme=dark"

    def test_comes_back(self):
        shown = self.page.evaluate("({...viewerState, c: 0, loaded: 0, table: sortStates.get('metrics').column, "
                                   "down: sortStates.get('metrics').descending, theme: document.documentElement.dataset.theme})")
        for name, value in {"right": "none", "compareKind": "false", "zoom": 2, "x": -0.5, "y": -0.25, "exposure": 1,
                            "channel": "g", "table": "Error.max", "down": True, "theme": "dark"}.items():
            self.assertEqual(shown[name], value, name)
        self.assertGreater(self.page.evaluate("document.querySelectorAll('.large canvas').length"), 1)

    def test_follows_what_is_done(self):
        self.page.key("e", "KeyE")
        self.page.key("2", "Digit2")
        self.page.wait_for("location.hash.includes('exposure=2')")
        self.assertIn(f"method={self.methods()[1]}", self.page.evaluate("location.hash"))


def load_tests(loader, tests, pattern):
    """Each class's own tests: a class for another state does not run the first one's again."""
    suite = unittest.TestSuite()
    for case in (ReportInBrowser, SavedState):
        suite.addTests(case(name) for name in loader.getTestCaseNames(case) if name in vars(case))
    return suite


if __name__ == "__main__":
    if FOLDER is None:
        sys.exit(__doc__)
    if not find_browser():
        print("skipped: no browser (Debian: apt-get install chromium)")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
