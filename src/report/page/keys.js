// Keys that work anywhere on the page, and the list of all keys.

const KEYS = [
  ["1 \u2026 9", "Flip to this method, in the order of the tiles: least error first"],
  ["Shift, held", "The truth, in every picture"], ["s", "The divider back to the middle"],
  ["e, d", "Exposure: a stop more, a stop less"], ["f", "False colour on and off"],
  ["c", "The next channel, of false colour and statistics"],
  ["r", "Mark a region: drag a rectangle; a click marks the whole picture"],
  [
    "+, \u2212, 0, arrows",
    "Zoom, fit and pan, once a picture has been clicked; the wheel and dragging do so too"
  ],
  ["t", "Light or dark"], ["?", "This list"]
];

function showHelp() {
  const close = h("button", {type: "button", onclick: () => dialog.close()}, "Close");
  const dialog =
      h("dialog", {class: "help", "aria-label": "Keys"}, h("h3", {}, "Keys"), facts(KEYS),
        h("p", {class: "hint"}, "The address of the page holds what is shown: copy it to share a view."),
        close);
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}

function nextChannel() {
  const next = CHANNELS[(CHANNELS.findIndex((c) => c.value === viewerState.channel) + 1) % CHANNELS.length];
  viewerParts.channel.show(next.value);
}

function toggleFalseColour() {
  const kind = viewerState.compareKind === "false" ? "picture" : "false";
  viewerParts.compareKind.show(kind);
  viewerParts.kind.show(kind);
}

const PAGE_KEYS = {
  "?": showHelp,
  t: () => setTheme(isDark() ? "light" : "dark"),
  s: () => setSplit(50),
  e: () => setExposure(viewerState.exposure + 1),
  d: () => setExposure(viewerState.exposure - 1),
  f: toggleFalseColour,
  c: nextChannel,
  r: () => markRegions(!viewerParts.root.classList.contains("marking"))
};

function onPageKey(event) {
  const typing = event.target.closest && event.target.closest("input, select, textarea, dialog");
  if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
  const needsViewer = event.key !== "?" && event.key !== "t";
  if (needsViewer && !viewerParts.root) return;
  // With Shift held a digit's key gives another sign: the code names the key itself.
  const digit = /^(?:Digit|Numpad)([1-9])$/.exec(event.code);
  if (event.key === "Shift")
    viewerParts.root.classList.add("truth-held");
  else if (digit)
    flipTo(Number(digit[1]) - 1);
  else if (Object.hasOwn(PAGE_KEYS, event.key))
    PAGE_KEYS[event.key]();
}

function releaseTruth() {
  if (viewerParts.root) viewerParts.root.classList.remove("truth-held");
}

document.addEventListener("keydown", onPageKey);
document.addEventListener("keyup", (event) => event.key === "Shift" && releaseTruth());
addEventListener("blur", releaseTruth);
