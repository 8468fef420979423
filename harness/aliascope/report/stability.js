// The map is walked by arrow keys, a table by a table; a cell opens its readings over it.

const { cells } = documentData;
const dialog = document.getElementById("readings");
const body = document.getElementById("readings-body");
const addressOf = (cell) => `cell=${encodeURIComponent(`${cell.component}/${cell.extreme}`)}`;

/** Text with its powers raised. */
function raised(text) {
  return text.split(/(?<=\d)\^(-?\d+)/).map((part, i) => (i % 2 ? h("sup", {}, minus(part)) : part));
}

// --- walking ---------------------------------------------------------------------------------------------------------

const grid = [...document.querySelectorAll(".map")].map((table) =>
  [...table.querySelectorAll("tbody tr:not(.kind)")].map((row) => [...row.querySelectorAll("td")].map((cell) => cell.querySelector("button"))));

/** The button of a table that is reached by the tab key. */
function rove(table, button) {
  for (const each of table.flat()) each?.setAttribute("tabindex", each === button ? "0" : "-1");
}

/** The next button in a direction, over what is empty; past the end of a column, the nearest of that row. */
function nextOf(table, row, column, down, across) {
  for (let [r, c] = [row + down, column + across]; table[r] && c >= 0 && c < table[r].length; r += down, c += across) {
    if (table[r][c]) return table[r][c];
    if (down) {
      const near = table[r].map((button, i) => [Math.abs(i - c), button]).filter(([, button]) => button).sort(([a], [b]) => a - b);
      if (near.length) return near[0][1];
    }
  }
  return null;
}

const ways = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowDown: [1, 0], ArrowUp: [-1, 0] };

grid.forEach((table) => {
  rove(table, table.flat().find(Boolean));
  table.forEach((buttons, row) => buttons.forEach((button, column) => button?.addEventListener("keydown", (event) => {
    const own = buttons.filter(Boolean);
    const to = event.key in ways ? nextOf(table, row, column, ...ways[event.key]) : { Home: own[0], End: own[own.length - 1] }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    if (!to) return;
    rove(table, to);
    to.focus();
  })));
});

// --- where there is more ---------------------------------------------------------------------------------------------

for (const box of document.querySelectorAll(".map-box")) {
  const tell = () => {
    box.parentElement.classList.toggle("more-right", box.scrollLeft + box.clientWidth < box.scrollWidth - 1);
    box.parentElement.classList.toggle("more-below", box.scrollTop + box.clientHeight < box.scrollHeight - 1);
  };
  box.addEventListener("scroll", tell, { passive: true });
  new ResizeObserver(tell).observe(box);
}

// --- one cell --------------------------------------------------------------------------------------------------------

let shown = null;
let opener = null;

function table(cell) {
  const rows = cell.readings.map((reading) => h("tr", {},
    h("th", { scope: "row" }, raised(reading.level)),
    h("td", { class: "number" }, reading.refused || reading.failed ? "–" : readingText(reading)),
    h("td", { class: "number" }, reading.lost === null ? (reading.error === "none" ? "all" : "–") : reading.lost.toFixed(1)),
    h("td", { class: reading.over || reading.failed ? "bad" : null },
      reading.failed ? `failed: ${reading.failed}` : reading.refused ? `declined: ${reading.refused}` : reading.over ? "past the bound" : "kept")));
  return h("div", { class: "readings-table" }, h("table", { class: "plain" },
    h("caption", { class: "hidden" }, "All readings, from mild to extreme"),
    h("thead", {}, h("tr", {}, h("th", { scope: "col" }, cell.axis), h("th", { scope: "col", class: "number" }, "error"),
      h("th", { scope: "col", class: "number" }, "digits lost"), h("th", { scope: "col" }, ""))),
    h("tbody", {}, rows)));
}

function about(cell) {
  const line = (name, value, wide) => (value ? h("div", { class: wide ? "wide" : null }, h("dt", {}, name), h("dd", {}, value)) : null);
  return h("dl", { class: "about" },
    line("Measured against", cell.against),
    line("Bound", `${plainFigure(cell.bound)} ${cell.unit}`),
    line("Precision of the result", figure(cell.precision, 2)),
    line("At its worst", cell.lost),
    line("Not there", cell.absent, true),
    line("Note", cell.note, true));
}

function open(index) {
  const cell = cells[index];
  shown = index;
  const step = (by, words) => h("button", { type: "button", class: "small", "aria-label": `${words} cell`, disabled: !cells[index + by], click: () => open(index + by) }, by < 0 ? "‹" : "›");
  const host = h("div", { class: "plot-host" });
  body.replaceChildren(
    h("div", { class: "dialog-head" }, h("h2", { id: "readings-title" }, `${cell.component}, ${cell.extreme}`),
      h("div", { class: "buttons" }, step(-1, "Previous"), step(1, "Next"), h("button", { type: "button", class: "small", click: () => dialog.close() }, "Close"))),
    h("p", { class: "soft" }, `${cell.title}.`),
    h("p", { class: "told" }, h("b", {}, raised(cell.told[0].toUpperCase() + cell.told.slice(1))), "."),
    host, about(cell), cell.readings.length ? table(cell) : "");
  if (!dialog.open) dialog.showModal();
  if (cell.readings.length) new ReadingsPlot(host, cell);
  dialog.scrollTop = 0;
  history.replaceState(null, "", `#${addressOf(cell)}`);
}

for (const button of document.querySelectorAll("button[data-cell]")) {
  button.addEventListener("click", () => {
    opener = button;
    open(Number(button.dataset.cell));
  });
}
dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
dialog.addEventListener("close", () => {
  history.replaceState(null, "", location.pathname + location.search);
  const now = document.querySelector(`.map button[data-cell="${shown}"]`);
  const own = grid.find((each) => each.flat().includes(now));
  if (own) rove(own, now);
  (opener?.closest(".said") ? opener : now)?.focus();
  opener = null;
});

function fromFragment() {
  const given = new URLSearchParams(location.hash.replace(/^#/, "")).get("cell");
  const index = cells.findIndex((cell) => `${cell.component}/${cell.extreme}` === given);
  if (index >= 0 && index !== (dialog.open ? shown : null)) open(index);
}

window.addEventListener("hashchange", fromFragment);
let drawnFor = window.innerWidth;
window.addEventListener("resize", () => {
  if (!dialog.open || Math.abs(window.innerWidth - drawnFor) < 2) return;
  drawnFor = window.innerWidth;
  open(shown);
});
fromFragment();
document.documentElement.dataset.ready = "";
