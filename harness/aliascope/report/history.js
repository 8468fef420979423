// The history of each mode: a list of modes with small lines, and one mode large, error above cost.

const { runs, machines, rows, metrics } = documentData;
const everywhere = "all scenes";
const errorMetric = "rmse";
const scenes = [...new Set(rows.map((row) => row.scene))];
const costs = metrics.filter((metric) => metric !== errorMetric);
const chosen = { scene: null, row: null, cost: costs[0] ?? null, find: "", stepped: false, run: runs.length - 1 };

const keyOf = (row) => `${row.renderer} ${row.mode}`;
const figuresOf = (row, metric) => row.figures.filter((one) => one.metric === metric);
const stepsOf = (row, metric) => row.steps.filter((step) => step.metric === metric);
const unitOf = (metric) =>
  ({ rmse: "RMSE", "cpu-seconds": "CPU seconds a picture", samples: "samples a picture" })[metric] ?? `${metric.slice(5)} rays a picture`;
const shortRevision = (text) => (text.length > 8 ? text.slice(0, 7) + (text.endsWith("+") ? "+" : "") : text);
const day = (run) => run.started.slice(0, 10);

// --- scales ----------------------------------------------------------------------------------------------------------

/** A linear scale round the values, or a logarithmic one where they differ by more than a factor of 20. */
function valueScale(values, from, to, least) {
  let low = Math.min(...values);
  let high = Math.max(...values);
  const log = low > 0 && high / low > 20;
  const t = log ? Math.log10 : (value) => value;
  [low, high] = [t(low), t(high)];
  const narrow = log ? 0.3 : least * Math.max(Math.abs(low), Math.abs(high)) || 1;
  const room = Math.max((high - low) * 0.1, (narrow - (high - low)) / 2);
  [low, high] = [low - room, high + room];
  return { log, low, high, at: (value) => from + ((t(value) - low) / (high - low)) * (to - from) };
}

/** Round values within a scale, and their texts, with as many digits as tell them apart. */
function ticksIn(scale) {
  if (scale.log) {
    const found = [];
    for (let power = Math.floor(scale.low); power <= scale.high; power++) {
      for (const digit of scale.high - scale.low < 2 ? [1, 2, 5] : [1]) found.push(Number(`${digit}e${power}`));
    }
    return found.filter((v) => Math.log10(v) > scale.low && Math.log10(v) < scale.high).map((value) => ({ value, text: figure(value, 1) }));
  }
  const raw = (scale.high - scale.low) / 4.5;
  const power = Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((m) => m * 10 ** power >= raw) * 10 ** power;
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const found = [];
  for (let k = Math.ceil(scale.low / step); k * step <= scale.high; k++) {
    const text = decimals > 7 ? scientific(k * step) : groups((k * step).toFixed(decimals));
    found.push({ value: k * step, text: minus(text) });
  }
  return found;
}

/** Where each run stands, from 0 to 1. */
const placeOf = (run) => (runs.length > 1 ? run / (runs.length - 1) : 0.5);

/** The levels between steps: [first run, last run, level], by mean or, of times, median. */
function levelsOf(one, steps) {
  const cuts = steps.filter((step) => step.machine === one.machine).map((step) => step.at).sort((a, b) => a - b);
  const found = [];
  for (const [i, from] of [-Infinity, ...cuts].entries()) {
    const points = one.points.filter(([run]) => run >= from && run < (cuts[i] ?? Infinity));
    if (!points.length) continue;
    const values = points.map(([, value]) => value).sort((a, b) => a - b);
    const middle = (values[(values.length - 1) >> 1] + values[values.length >> 1]) / 2;
    const level = one.kind === "ranks" ? middle : values.reduce((a, b) => a + b) / values.length;
    found.push([points[0][0], points[points.length - 1][0], level]);
  }
  return found;
}

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

// --- one mode, large -------------------------------------------------------------------------------------------------

const margin = { top: 26, right: 16, bottom: 34, left: 62 };

class RunPlot {
  constructor(host, row, metric) {
    Object.assign(this, { row, metric });
    this.svg = s("svg", { class: "plot runs", tabindex: "0", role: "img", "aria-label": this.summary() });
    this.tip = h("div", { class: "tip", hidden: true });
    this.box = h("div", { class: "plot-box" }, this.svg, this.tip);
    host.append(h("figure", {}, this.box));
    this.width = Math.max(280, this.box.clientWidth || 640);
    this.height = clamp(Math.round(this.width * 0.36), 190, 280);
    this.draw();
    this.svg.addEventListener("pointermove", (event) => this.point(this.nearest(event)));
    this.svg.addEventListener("pointerleave", () => this.leave());
    this.svg.addEventListener("focus", () => this.svg.matches(":focus-visible") && this.point(chosen.run));
    this.svg.addEventListener("blur", () => this.leave());
    this.svg.addEventListener("keydown", (event) => this.key(event));
  }

  summary() {
    const steps = stepsOf(this.row, this.metric).map((step) => `${step.change} ${step.where}`);
    return `${unitOf(this.metric)} of ${keyOf(this.row)} over ${counted(runs.length, "run")}; `
      + `${steps.length ? `steps: ${steps.join("; ")}` : "no steps"}. Arrow keys go from run to run.`;
  }

  x(run) {
    const inset = runs.length < 8 ? 40 : 10;
    return margin.left + inset + placeOf(run) * (this.width - margin.left - margin.right - 2 * inset);
  }

  draw() {
    const { svg, row, metric, width, height } = this;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.figures = figuresOf(row, metric);
    const points = this.figures.flatMap((one) => one.points.map((point) => ({ one, point })));
    const bottom = height - margin.bottom;
    svg.append(s("text", { class: "axis-title", x: 0, y: 13 }, row.scene === everywhere ? "CPU time over its own median, median of all modes" : unitOf(metric)));
    this.drawRevisions(bottom);
    if (!points.length) {
      svg.append(s("text", { x: width / 2, y: height / 2, "text-anchor": "middle" }, "No run has a figure."));
      return;
    }
    const spread = points.flatMap(({ one, point: [, value, error] }) => (one.kind === "errors" && error ? [value - error, value + error] : [value]));
    const y = valueScale(spread, bottom - 4, margin.top + 14, 0.02);
    const grid = s("g", { class: "grid" });
    for (const { value, text } of ticksIn(y)) {
      const at = y.at(value);
      grid.append(s("line", { class: "strong", x1: margin.left, x2: width - margin.right, y1: at, y2: at }),
        s("text", { x: margin.left - 7, y: at + 4, "text-anchor": "end" }, text));
    }
    svg.append(grid);
    const steps = stepsOf(row, metric);
    for (const step of steps) this.drawBand(step, bottom);
    for (const one of this.figures) this.drawSeries(one, y, steps);
    this.drawFailed(y);
    this.drawStepTexts(steps);
    this.cursor = s("line", { class: "cursor", y1: margin.top - 6, y2: bottom, visibility: "hidden" });
    svg.append(this.cursor);
  }

  /** Revisions as ticks, as many as there is room for; the last always. */
  drawRevisions(bottom) {
    const first = runs.flatMap((run, i) => (i === 0 || runs[i - 1].revision !== run.revision ? [i] : []));
    const last = first[first.length - 1];
    const node = s("g", { class: "grid" });
    let free = Infinity;
    for (const i of first.reverse()) {
      const x = this.x(i);
      node.append(s("line", { class: "strong", x1: x, x2: x, y1: bottom, y2: bottom + 4 }));
      if (i !== last && x > free) continue;
      const anchor = x > this.width - 32 ? "end" : "middle";
      const end = anchor === "end" ? this.width : x;
      free = (anchor === "end" ? end - 31 : end) - 70;
      node.append(s("text", { class: "revision", x: end, y: bottom + 16, "text-anchor": anchor }, shortRevision(runs[i].revision)),
        s("text", { x: end, y: bottom + 29, "text-anchor": anchor, "font-size": "10px" }, day(runs[i])));
    }
    this.svg.append(node, s("line", { class: "axis", x1: margin.left, x2: this.width - margin.right, y1: bottom, y2: bottom, stroke: "currentColor", "stroke-opacity": 0.4 }));
  }

  drawBand(step, bottom) {
    const [from, to] = [this.x(step.before), this.x(step.after)];
    const way = step.up ? "up" : "down";
    const at = (this.x(Math.max(step.at - 1, step.before)) + this.x(step.at)) / 2;
    this.svg.append(
      s("rect", { class: `step-band ${way}`, x: from, y: margin.top - 6, width: Math.max(1, to - from), height: bottom - margin.top + 6 }),
      s("line", { class: `step-mark ${way}`, x1: at, x2: at, y1: margin.top - 6, y2: bottom }));
  }

  /** How large each step is, in two lines where they would lie over each other; what has no room is in the list above. */
  drawStepTexts(steps) {
    const free = [-Infinity, -Infinity];
    for (const step of [...steps].sort((a, b) => a.at - b.at)) {
      const text = `${step.up ? "▲" : "▼"} ${step.change}`;
      const wide = text.length * 6.6;
      const at = clamp((this.x(Math.max(step.at - 1, step.before)) + this.x(step.at)) / 2, margin.left + wide / 2, this.width - wide / 2);
      const line = free.findIndex((end) => at - wide / 2 > end + 6);
      if (line < 0) continue;
      free[line] = at + wide / 2;
      this.svg.append(s("text", { class: `step-text ${step.up ? "up" : "down"}`, x: at, y: margin.top + 3 + 14 * line, "text-anchor": "middle" }, text));
    }
  }

  drawSeries(one, y, steps) {
    const colour = colourOf(this.row.renderer);
    const places = one.points.map(([run, value]) => [this.x(run), y.at(value)]);
    const group = s("g", { stroke: colour });
    group.append(s("path", { class: "series-line", d: `M${places.map((place) => place.join(" ")).join("L")}` }));
    const few = one.kind === "ranks" && one.points.length < 5; // no level to speak of
    for (const [from, to, level] of levelsOf(one, steps)) {
      if (to > from && !few) group.append(s("path", { class: "level", d: `M${this.x(from)} ${y.at(level)}H${this.x(to)}` }));
    }
    const size = runs.length > 120 ? 0.5 : runs.length > 60 ? 0.65 : 0.85;
    one.points.forEach(([, value, error], i) => {
      const [px, py] = places[i];
      if (one.kind === "errors" && error) {
        group.append(s("line", { class: "bar", x1: px, x2: px, y1: y.at(Math.max(value - error, value * 1e-3)), y2: y.at(value + error) }));
      }
      const shape = shapes[(one.machine ?? runs[one.points[i][0]].machine) % shapes.length];
      group.append(s("path", { class: "point", d: shape, fill: colour, transform: `translate(${px} ${py}) scale(${size})` }));
    });
    this.svg.append(group);
  }

  /** Rings around the runs in which a check of the mode failed; a cross at the bottom where there is no figure. */
  drawFailed(y) {
    for (const run of this.row.failed) {
      const point = this.figures.flatMap((one) => one.points).find(([index]) => index === run);
      const at = [this.x(run), point ? y.at(point[1]) : this.height - margin.bottom - 8];
      const d = point ? "M-8 0a8 8 0 1 0 16 0a8 8 0 1 0-16 0z" : "M-4-4 4 4M4-4-4 4";
      this.svg.append(s("path", { class: "failed", d, transform: `translate(${at.join(" ")})` }));
    }
  }

  nearest(event) {
    const box = this.svg.getBoundingClientRect();
    const x = ((event.clientX - box.left) * this.width) / box.width;
    let best = 0;
    for (let i = 1; i < runs.length; i++) if (Math.abs(this.x(i) - x) < Math.abs(this.x(best) - x)) best = i;
    return best;
  }

  point(run) {
    chosen.run = run;
    for (const plot of plots) plot.showCursor(run);
    this.showTip(run);
  }

  leave() {
    for (const plot of plots) plot.showCursor(null);
    this.tip.hidden = true;
  }

  showCursor(run) {
    if (!this.cursor) return;
    this.cursor.setAttribute("visibility", run === null ? "hidden" : "visible");
    if (run === null) return;
    this.cursor.setAttribute("x1", this.x(run));
    this.cursor.setAttribute("x2", this.x(run));
  }

  key(event) {
    const to = { ArrowRight: chosen.run + 1, ArrowLeft: chosen.run - 1, Home: 0, End: runs.length - 1 }[event.key];
    if (event.key === "Escape") this.leave();
    if (to === undefined) return;
    this.point(clamp(to, 0, runs.length - 1));
    announce([...this.tip.querySelectorAll("p, dl div")].map((node) => node.textContent).join("; "));
    event.preventDefault();
  }

  valueText(run) {
    for (const one of this.figures) {
      const point = one.points.find(([index]) => index === run);
      if (!point) continue;
      const [, value, error] = point;
      return error ? `${figure(value, 4)} ${uncertainty(value, error)}` : figure(value, Number.isInteger(value) ? 12 : 4);
    }
    return "none";
  }

  showTip(index) {
    const run = runs[index];
    const line = (name, value) => h("div", {}, h("dt", {}, name), " ", h("dd", {}, value));
    const before = index > 0 ? runs[index - 1] : run;
    const changed = Object.entries(run.versions).filter(([name, version]) => before.versions[name] !== version);
    const shown = changed.length ? changed : Object.entries(run.versions);
    const steps = stepsOf(this.row, this.metric).filter((step) => step.at === index);
    this.tip.replaceChildren(
      h("p", {}, h("b", { class: "spec" }, run.revision), run.passed ? null : h("span", { class: "bad" }, " did not pass")),
      h("dl", {},
        line("began", `${run.started.slice(0, 16).replace("T", " ")}`),
        line(this.metric, this.valueText(index)),
        this.row.failed.includes(index) ? line("this mode", h("span", { class: "bad" }, "failed")) : null,
        steps.map((step) => line("step", `${step.change}, ${step.why}`)),
        line("machine", run.machine === null ? "unknown" : machines[run.machine]),
        line("system", run.system),
        shown.map(([name, version]) => line(changed.length ? `${name}, new` : name, version))));
    this.tip.hidden = false;
    const unit = this.svg.getBoundingClientRect().width / this.width;
    const x = this.x(index) * unit;
    const left = x + 14 + this.tip.offsetWidth > this.svg.clientWidth ? x - 14 - this.tip.offsetWidth : x + 14;
    this.tip.style.left = `${clamp(left, 0, Math.max(0, this.svg.clientWidth - this.tip.offsetWidth))}px`;
    // Where there is no room beside the points, below them.
    this.tip.style.top = `${this.svg.clientWidth < 520 ? this.svg.clientHeight : margin.top * unit}px`;
  }
}

let plots = [];

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
  const shown = [errorMetric, chosen.cost].filter((metric) => metric && (row.scene !== everywhere || figuresOf(row, metric).length));
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

/** The row with the newest step, or the first. */
function newest(own) {
  const latest = (row) => Math.max(-1, ...row.steps.map((step) => step.at));
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
