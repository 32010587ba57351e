// Tables that sort by their heads: by a click, or by Enter on a head that has the focus. Once: ascending;
// twice: descending; again: as they came.

// By a table's key: {column, descending}; tables of one key sort alike, and keep their order when drawn
// again.
const sortStates = new Map();

const RAISED = "\u207b" + SUPERSCRIPT;
const loweredDigit = (digit) => digit === "\u207b" ? "-" : String(SUPERSCRIPT.indexOf(digit));

// What a cell is sorted by: data-value, else its text, as a number where it begins with one.
function sortValue(cell) {
  if (!cell) return null;
  const text = (cell.dataset.value === undefined ? cell.textContent : cell.dataset.value).trim();
  if (text === "" || text === EN_DASH) return null;
  const plain =
      text.replaceAll(MINUS, "-")
          .replaceAll(NARROW_SPACE, "")
          .replace(
              new RegExp(`^<|^([+-]?)10(?=[${RAISED}])|${TIMES}10(?=[${RAISED}])`),
              (_, sign) => sign === undefined ? "" : sign + "1")
          .replace(
              new RegExp(`(?<=\\d)[${RAISED}]+`), (power) => "e" + [...power].map(loweredDigit).join(""));
  const found = /^[+-]?\d[\d.]*(e-?\d+)?/.exec(plain);
  return found ? Number(found[0]) : text;
}

// Numbers before words; what has no value stands last, either way.
function compareValues(a, b, descending) {
  if (a === null || b === null) return (a === null) - (b === null);
  if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;
  const order = typeof a === "number" ? a - b : a.localeCompare(b);
  return descending ? -order : order;
}

function showOrder(table) {
  const {heads, rows, key} = table.sorting, state = sortStates.get(key);
  const index = state ? heads.findIndex((head) => head.dataset.sort === state.column) : -1;
  heads.forEach((head, i) => {
    const on = i === index;
    if (on)
      head.setAttribute("aria-sort", state.descending ? "descending" : "ascending");
    else
      head.removeAttribute("aria-sort");
  });
  const ordered = index < 0 ?
      rows :
      rows.map(
              (row) => ({row, value: row.cells.length === heads.length ? sortValue(row.cells[index]) : null}))
          .sort((a, b) => compareValues(a.value, b.value, state.descending))
          .map(({row}) => row);
  table.tBodies[0].append(...ordered);
}

function sortBy(key, column) {
  const old = sortStates.get(key);
  if (old && old.column === column && old.descending)
    sortStates.delete(key);
  else
    sortStates.set(key, {column, descending: Boolean(old) && old.column === column});
  for (const table of document.querySelectorAll("table.sortable"))
    if (table.sorting.key === key) showOrder(table);
  saveState();
}

// A table whose last row of heads, or the one given, has a head for each column. `key`: one for all tables
// that sort together.
function sortable(table, key, row = table.tHead.rows.length - 1) {
  const heads = [...table.tHead.rows[row].cells], rows = [...table.tBodies[0].rows];
  if (rows.length < 3) return table;
  table.sorting = {key, heads, rows};
  table.classList.add("sortable");
  heads.forEach((head, i) => {
    head.dataset.sort = head.dataset.sort || String(i);
    head.scope = "col";
    const unit = head.querySelector("small");
    const named = [...head.childNodes].filter((node) => node !== unit);
    const button = h("button", {type: "button", onclick: () => sortBy(key, head.dataset.sort)}, named);
    if (button.textContent.trim() === "") button.setAttribute("aria-label", "Sort by this column");
    head.prepend(button);
  });
  showOrder(table);
  return table;
}
