// One box of text beside the pointer, for whatever carries data-tip.

const tipBox = h("div", {class: "tip", hidden: true});
document.body.append(tipBox);

function placeTip(event) {
  const target = event.target.closest && event.target.closest("[data-tip]");
  tipBox.hidden = !target;
  if (!target) return;
  tipBox.textContent = target.dataset.tip;
  const {width, height} = tipBox.getBoundingClientRect();
  tipBox.style.left = `${Math.min(event.clientX + 14, innerWidth - width - 8)}px`;
  tipBox.style.top =
      `${event.clientY + 18 + height > innerHeight ? event.clientY - height - 10 : event.clientY + 18}px`;
}
document.addEventListener("pointermove", placeTip);
document.addEventListener("scroll", () => (tipBox.hidden = true), {passive: true});
