// Puts the page together.

const SECTIONS = [
  ["overview", "Overview"], ["speed", "Speed against accuracy"], ["pictures", "Pictures"],
  ["metrics", "Metrics"], ...(ladders.length > 0 ? [["ladders", "Assumptions"]] : []),
  ...(termGroups().length > 0 ? [["terms", "Gaussians"]] : []), ["halos", "Halos"], ["what", "What was run"]
];

document.getElementById("head").append(...pageHead().filter(Boolean));
document.getElementById("nav").append(...SECTIONS.map(([id, title]) => h("a", {href: "#" + id}, title)));
append(
    document.getElementById("main"),
    [
      overview(), costSection(), pictureSection(), tableSection(), ladderSection(), termsSection(), haloSection(),
      detailsSection()
    ]);
document.documentElement.dataset.ready = "yes";
