// Elements and numbers: what every part of the page is made of.

const EN_DASH = "\u2013";
const MINUS = "\u2212";
const TIMES = "\u00d7";
const NARROW_SPACE = "\u202f";
const SVG_NAMESPACE = document.getElementById("svg").namespaceURI;

function append(element, children) {
  for (const child of children.flat(Infinity)) {
    if (child === null || child === undefined || child === false) continue;
    element.append(child instanceof Node ? child : String(child));
  }
  return element;
}

function setAttributes(element, attributes) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on"))
      element.addEventListener(name.slice(2), value);
    else if (name === "style")
      element.style.cssText = value;
    else
      element.setAttribute(name, value === true ? "" : value);
  }
  return element;
}

// An HTML element. Children are nodes or text; text is never read as markup.
function h(tag, attributes, ...children) {
  return append(setAttributes(document.createElement(tag), attributes), children);
}

// An SVG element.
function s(tag, attributes, ...children) {
  return append(setAttributes(document.createElementNS(SVG_NAMESPACE, tag), attributes), children);
}

const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

// 12345 -> "12 345", with spaces that do not break.
function grouped(text) {
  const [whole, fraction] = text.split(".");
  const spaced = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, NARROW_SPACE) : whole;
  return fraction === undefined ? spaced : spaced + "." + fraction;
}

// Three significant digits, but never more than four decimals; a dash for what is no number.
function number(value, signed = false) {
  if (!isNumber(value)) return EN_DASH;
  if (value === 0) return "0";
  const size = Math.abs(value) < 1000 ? Number(Math.abs(value).toPrecision(3)) : Math.abs(value);
  const sign = value < 0 ? MINUS : signed ? "+" : "";
  if (size < 0.00005) return sign + "<0.0001";
  const decimals = Math.min(4, Math.max(0, 2 - Math.floor(Math.log10(size))));
  return sign + grouped(size.toFixed(decimals));
}

const count = (value) => (isNumber(value) ? grouped(String(Math.round(value))) : EN_DASH);
const percent = (value) => (isNumber(value) ? number(100 * value) + NARROW_SPACE + "%" : EN_DASH);

const SUPERSCRIPT = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";

function powerOfTen(exponent) {
  const digits = [...String(Math.abs(exponent))].map((d) => SUPERSCRIPT[Number(d)]).join("");
  return "10" + (exponent < 0 ? "\u207b" : "") + digits;
}

// 2.5e-5 -> "2.5 x 10^-5"; for values that span decades.
function scientific(value, digits = 2) {
  if (!isNumber(value)) return EN_DASH;
  if (value === 0) return "0";
  if (Math.abs(value) >= 0.01 && Math.abs(value) < 1000) return number(value);
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  return (Number(mantissa) === 1 ? "" : mantissa.replace("-", MINUS) + NARROW_SPACE + TIMES + NARROW_SPACE) +
      powerOfTen(Number(exponent));
}

const unique = (values) => [...new Set(values)];
const plural = (n, one, many = one + "s") => `${n} ${n === 1 ? one : many}`;

// "a, b and c", of nodes or text.
function listed(items) {
  return items.flatMap((item, i) => (i === 0 ? [item] : [i === items.length - 1 ? " and " : ", ", item]));
}

// One of several: a row of buttons that says which is on. `options`: [{value, text}]. `mark` shows a choice,
// `show` makes it too.
function choice(caption, options, value, onchange) {
  const buttons = options.map(
      (option) => h(
          "button",
          {type: "button", "aria-pressed": String(option.value === value), onclick: () => pick(option.value)},
          option.text));
  const mark = (chosen) => options.forEach(
      (option, i) => buttons[i].setAttribute("aria-pressed", String(option.value === chosen)));
  function pick(chosen) {
    mark(chosen);
    onchange(chosen);
  }
  const element =
      h("div", {class: "choice", role: "group", "aria-label": caption},
        h("span", {class: "caption"}, caption), buttons);
  return {element, mark, show: pick};
}

function section(id, title, lead, ...children) {
  return h("section", {id}, h("h2", {}, title), lead && h("p", {class: "lead"}, lead), children);
}
