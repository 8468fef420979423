// The history of each mode: a list of modes with small lines, and one mode large, error above cost.

// --- the list --------------------------------------------------------------------------------------------------------

function spark(row, metric) {
  const figures = figuresOf(row, metric);
  const values = figures.flatMap((one) => one.points.map(([, value]) => value));
  if (!values.length) return h("span", { class: "soft" }, "–");
  // One slow run shall not flatten the rest: it is cut off.
  const sorted = [...values].sort((a, b) => a - b);
  const cut = Math.floor(values.length * 0.06);
  const [least, most] = [sorted[cut], sorted[sorted.length - 1 - cut]];
  const y = valueScale([least, most], 26, 2, 0.04);
  const height = (value) => y.at(clamp(value, least, most));
  const x = (run) => 2 + 82 * placeOf(run);
  const node = s("svg", { class: "spark", viewBox: "0 0 86 28", preserveAspectRatio: "none", "aria-hidden": "true" });
  for (const step of stepsOf(row, metric)) {
    const at = (x(step.at - 1) + x(step.at)) / 2;
    node.append(s("line", { class: `mark ${step.up ? "up" : "down"}`, x1: at, x2: at, y1: 0, y2: 28 }));
  }
  for (const one of figures) {
    const places = one.points.map(([run, value]) => `${x(run).toFixed(1)} ${height(value).toFixed(1)}`);
    const d = places.length > 1 ? `M${places.join("L")}` : `M${places[0]}h0.01`;
    node.append(s("path", { class: "line", d, stroke: colourOf(row.renderer), "stroke-linecap": "round" }));
  }
  return node;
}

const listHost = document.getElementById("list");
const detailHost = document.getElementById("detail");

function rowsShown() {
  const words = chosen.find.toLowerCase().split(/\s+/).filter(Boolean);
  return rows.filter((row) => row.scene === chosen.scene
    && words.every((word) => keyOf(row).toLowerCase().includes(word)) && (!chosen.stepped || row.steps.length));
}

function drawList() {
  const shown = rowsShown();
  const list = h("ul", {}, shown.map((row) => {
    const steps = row.steps.length ? `, ${counted(row.steps.length, "step")}` : "";
    const dot = h("span", { class: "dot", "aria-hidden": "true" });
    dot.style.backgroundColor = colourOf(row.renderer);
    const button = h("button",
      { type: "button", class: "row", "aria-label": `${keyOf(row)}${steps}`, "aria-pressed": String(row === chosen.row), click: () => choose({ row }) },
      h("span", { class: "who" }, dot, h("b", {}, row.renderer), " ", spec(row.mode)), spark(row, errorMetric), chosen.cost ? spark(row, chosen.cost) : null);
    return h("li", {}, button);
  }));
  list.addEventListener("keydown", (event) => {
    const buttons = [...list.querySelectorAll("button")];
    const next = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const now = buttons.indexOf(document.activeElement);
    if (!next || now < 0) return;
    buttons[clamp(now + next, 0, buttons.length - 1)].focus();
    event.preventDefault();
  });
  listHost.classList.toggle("short", shown.length <= 16);
  listHost.replaceChildren(
    h("p", { class: "heads", "aria-hidden": "true" }, h("span", {}, counted(shown.length, "mode")), h("span", {}, "error"), h("span", {}, costWord())),
    shown.length ? list : h("p", { class: "notice" }, "No mode of this scene is so named."));
}

const costWord = () => ({ "cpu-seconds": "CPU time", samples: "samples" })[chosen.cost] ?? (chosen.cost ? `${chosen.cost.slice(5)} rays` : "");

function markRow() {
  const shown = rowsShown();
  listHost.querySelectorAll(".row").forEach((node, i) => node.setAttribute("aria-pressed", String(shown[i] === chosen.row)));
}

// --- what is shown large ---------------------------------------------------------------------------------------------

function drawDetail() {
  const { row } = chosen;
  plots = [];
  detailHost.replaceChildren();
  if (!row) return;
  const dot = h("span", { class: "dot", "aria-hidden": "true" });
  dot.style.backgroundColor = colourOf(row.renderer);
  const failed = row.failed.length ? ` · failed in ${counted(row.failed.length, "run")}` : "";
  detailHost.append(h("h3", {}, dot, row.renderer, " ", spec(row.mode)),
    h("p", { class: "facts-line" }, `${row.scene} · ${row.steps.length ? counted(row.steps.length, "step") : "no steps"}${failed}`));
  const shown = [errorMetric, chosen.cost].filter((metric) => metrics.includes(metric) && (row.scene !== everywhere || figuresOf(row, metric).length));
  plots = shown.map((metric) => new RunPlot(detailHost, row, metric));
  const key = h("p", { class: "key" });
  if (machines.length > 1) {
    machines.forEach((name, i) => key.append(h("span", {}, s("svg", { class: "marker", viewBox: "-6 -6 12 12", width: 12, height: 12, "aria-hidden": "true" },
      s("path", { d: shapes[i % shapes.length], fill: colourOf(row.renderer) })), name)));
  }
  if (row.failed.length) key.append(h("span", { class: "bad" }, "red ring, cross: a check failed"));
  if (row.steps.length) key.append(h("span", {}, "tinted: where the step may lie"));
  if (key.childNodes.length) detailHost.append(key);
}

// --- what is chosen --------------------------------------------------------------------------------------------------

let writing = 0;

function writeFragment() {
  const out = new URLSearchParams();
  out.set("scene", chosen.scene);
  if (chosen.row) out.set("mode", keyOf(chosen.row));
  if (chosen.cost !== costs[0]) out.set("cost", chosen.cost);
  history.replaceState(null, "", `#${out.toString().replaceAll("%3A", ":").replaceAll("%2C", ",").replaceAll("%3D", "=")}`);
}

/** Changes what is shown; a scene that is chosen shows the same mode, where it has it, or the one with the newest step. */
function choose(patch) {
  const before = { ...chosen };
  Object.assign(chosen, patch);
  if (patch.row) chosen.scene = patch.row.scene;
  if (chosen.scene !== before.scene && !patch.row) {
    const own = rows.filter((row) => row.scene === chosen.scene);
    chosen.row = own.find((row) => before.row && keyOf(row) === keyOf(before.row)) ?? newest(own);
  }
  const same = chosen.scene === before.scene && chosen.find === before.find && chosen.stepped === before.stepped && chosen.cost === before.cost;
  if (same) markRow();
  else drawList();
  if (chosen.row !== before.row || chosen.cost !== before.cost) drawDetail();
  showChoices();
  clearTimeout(writing);
  writing = setTimeout(writeFragment, 120);
}

/** The row with the newest step; or the first, rather one of a scene. */
function newest(own) {
  const latest = (row) => Math.max(row.scene === everywhere ? -2 : -1, ...row.steps.map((step) => step.at));
  return own.reduce((a, b) => (a && latest(a) >= latest(b) ? a : b), null);
}

const sceneSelect = h("select", { id: "scene", change: () => choose({ scene: sceneSelect.value }) },
  scenes.map((name) => h("option", { value: name }, name)));
const costSelect = h("select", { id: "cost", change: () => choose({ cost: costSelect.value }) },
  costs.map((name) => h("option", { value: name }, unitOf(name))));
const findInput = h("input", { type: "text", id: "find", placeholder: "such as povray am2", input: () => choose({ find: findInput.value }) });
const steppedInput = h("input", { type: "checkbox", id: "stepped", change: () => choose({ stepped: steppedInput.checked }) });

function showChoices() {
  sceneSelect.value = chosen.scene;
  if (chosen.cost) costSelect.value = chosen.cost;
  steppedInput.checked = chosen.stepped;
}

function fromFragment() {
  const given = new URLSearchParams(location.hash.replace(/^#/, ""));
  const scene = scenes.includes(given.get("scene")) ? given.get("scene") : null;
  const cost = costs.includes(given.get("cost")) ? given.get("cost") : chosen.cost;
  const own = rows.filter((row) => row.scene === scene);
  return { cost, row: own.find((row) => keyOf(row) === given.get("mode")) ?? newest(scene ? own : rows) };
}

const name = (text) => h("span", { class: "name" }, text);
document.getElementById("choices").append(
  h("label", {}, name("Scene"), sceneSelect),
  costs.length > 1 ? h("label", {}, name("Cost"), costSelect) : "",
  h("label", {}, name("Find"), findInput),
  h("label", {}, steppedInput, name("only what changed")));
for (const node of document.querySelectorAll(".step .dot")) node.style.backgroundColor = colourOf(node.dataset.renderer);
for (const node of document.querySelectorAll("button.step")) {
  node.addEventListener("click", () => {
    const { row, metric } = node.dataset;
    findInput.value = "";
    choose({ row: rows[Number(row)], find: "", stepped: false, ...(metric === errorMetric ? {} : { cost: metric }) });
    document.getElementById("modes").scrollIntoView();
    plots.find((plot) => plot.metric === metric)?.svg.focus({ preventScroll: true });
  });
}
window.addEventListener("hashchange", () => choose(fromFragment()));
let drawnFor = 0;
new ResizeObserver(() => {
  if (Math.abs(detailHost.clientWidth - drawnFor) < 2) return;
  drawnFor = detailHost.clientWidth;
  drawDetail();
}).observe(detailHost);
choose(fromFragment());
document.documentElement.dataset.ready = "";
