// One mode over the runs: an error or a cost, its steps, and what is known of the run under the cursor.

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

let plots = []; // that are shown: their cursors go together
