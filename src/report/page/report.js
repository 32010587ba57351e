// Puts the page together.

const isDark = () => {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
};

// "light" or "dark"; until one is chosen, the page follows the system.
function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  redrawCharts();
  saveState();
}

const SECTIONS = [
  ["overview", "Overview"], ...(sweep ? [["sweep", "Difficulty"]] : []), ["speed", "Speed against accuracy"],
  ["pictures", "Pictures"], ["metrics", "Metrics"],
  ...(ladders.length > 0 ? [["ladders", "Assumptions"]] : []),
  ...(termGroups().length > 0 ? [["terms", "Gaussians"]] : []),
  ...(stabilityRuns.length > 0 ? [["stability", "Over views"]] : []), ["halos", "Halos"],
  ...(hasSeam() ? [["seams", "UV seams"]] : []), ["what", "What was run"]
];

document.getElementById("head").append(...pageHead().filter(Boolean));
document.getElementById("nav").append(
    ...SECTIONS.map(([id, title]) => h("a", {href: "#" + id}, title)),
    h("button", {
      type: "button",
      class: "theme",
      title: "Light or dark (t)",
      onclick: () => setTheme(isDark() ? "light" : "dark")
    },
      "\u25d0"));
if (["light", "dark"].includes(saved.theme)) setTheme(saved.theme);
append(document.getElementById("main"), [
  overview(), sweepSection(), costSection(), pictureSection(), tableSection(), ladderSection(),
  termsSection(), stabilitySection(), haloSection(), seamSection(), detailsSection()
]);
document.documentElement.dataset.ready = "yes";
if (saved.view && viewerParts.root) viewerParts.root.scrollIntoView({block: "start"});
addEventListener("hashchange", () => location.hash.includes("=") && location.reload());
