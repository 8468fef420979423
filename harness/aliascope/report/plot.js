// Error against cost, log-log: a colour a renderer, a shape a family, a line along each, the Pareto front behind.

const plotMargin = { top: 30, right: 14, bottom: 40, left: 52 };

/** A logarithmic or linear scale from the data to pixels, with room at both ends. */
function axisScale(values, from, to, linear) {
  const t = linear ? same : Math.log10;
  let low = Math.min(...values.map(t));
  let high = Math.max(...values.map(t));
  const least = linear ? 1 : 0.5;
  const room = Math.max((high - low) * 0.06, (least - (high - low)) / 2, linear ? 0.2 : 0.06);
  low -= room;
  high += room;
  const at = (value) => from + ((t(value) - low) / (high - low)) * (to - from);
  return { at, low, high, linear, from, to };
}

/** [{value, text, strong}] of an axis: the decades, and 2 and 5 between them where there are few. */
function ticksOf(scale) {
  const ticks = [];
  if (scale.linear) {
    const raw = (scale.high - scale.low) / 6;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find((m) => m * power >= raw) * power;
    for (let v = Math.ceil(scale.low / step); v * step <= scale.high; v++) ticks.push({ value: v * step, strong: true });
    return ticks;
  }
  const decades = scale.high - scale.low;
  for (let power = Math.floor(scale.low); power <= Math.ceil(scale.high); power++) {
    for (let digit = 1; digit <= 9; digit++) {
      const place = power + Math.log10(digit);
      if (place < scale.low || place > scale.high) continue;
      const labelled = digit === 1 || (decades < 2.2 && (digit === 2 || digit === 5)) || (decades < 0.7 && digit < 9);
      ticks.push({ value: Number(`${digit}e${power}`), strong: digit === 1, labelled });
    }
  }
  return ticks;
}

function tickText(value) {
  if (value >= 0.001 && value < 10000) return String(Number(value.toPrecision(2)));
  const [mantissa, power] = value.toExponential(0).split("e");
  const ten = `10${superscript(Number(power))}`;
  return mantissa === "1" ? ten : `${mantissa}·${ten}`;
}

class Plot {
  /** `rows` are those of a scene or the pooled ones; `host` is the element to fill. */
  constructor(host, rows, title) {
    this.host = host;
    this.rows = rows;
    this.title = title;
    this.hidden = new Set();
    this.svg = s("svg", { class: "plot", role: "group", "aria-label": `${title}: error against cost` });
    this.tip = h("div", { class: "tip", hidden: true });
    this.note = h("figcaption", { class: "note" });
    host.append(h("figure", {}, h("div", { class: "plot-box" }, this.svg, this.tip), this.note));
    this.svg.addEventListener("pointermove", (event) => this.hover(event));
    this.svg.addEventListener("pointerleave", () => this.showTip(null));
    this.svg.addEventListener("click", (event) => this.pick(event));
    this.svg.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => {
      if (host.clientWidth && host.clientWidth !== this.width) this.draw();
    }).observe(host);
  }

  /** Shows other rows, of a scene or pooled. */
  show(rows) {
    this.rows = rows;
    this.draw();
  }

  draw() {
    const metric = metricOf(state.metric);
    this.metric = metric;
    this.cost = costs[state.cost];
    this.width = this.host.clientWidth || 640;
    this.height = clamp(Math.round(this.width * 0.6), 330, 600);
    const sorted = this.sortRows(metric);
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    this.svg.replaceChildren();
    this.points = [];
    if (!sorted.plain.length) {
      this.svg.append(s("text", { x: this.width / 2, y: this.height / 2, class: "axis-title", "text-anchor": "middle" },
        `Nothing to plot: no mode has both an error and ${state.cost === "cpu" ? "a time" : this.cost.name}.`));
      this.note.replaceChildren(...this.remarks(sorted, metric));
      return;
    }
    const bottom = this.height - plotMargin.bottom - (sorted.zero.length ? 20 : 0);
    this.bottom = bottom;
    this.x = axisScale([...sorted.plain, ...sorted.zero].map((row) => this.cost.of(row)[0]), plotMargin.left, this.width - plotMargin.right, false);
    this.y = axisScale(sorted.plain.map((row) => badnessOf(row, metric)), bottom, plotMargin.top, metric.linear);
    this.drawAxes(metric, sorted);
    this.drawQuantisation(metric);
    this.drawFront(metric);
    this.drawFamilies(sorted.plain, metric);
    this.drawPoints(sorted, metric);
    this.marks = s("g", { class: "marks" });
    this.svg.append(this.marks);
    this.mark();
    this.applyHidden();
    this.note.replaceChildren(...this.remarks(sorted, metric));
  }

  /** Rows that have a place in the plot, those with no error at all (on a rail below), and those without a figure. */
  sortRows(metric) {
    const plain = [], zero = [], without = [];
    for (const row of this.rows) {
      const badness = badnessOf(row, metric);
      if (!(this.cost.of(row)[0] > 0) || badness === null) without.push(row);
      else if (metric.linear ? badness === -Infinity : badness <= 0) zero.push(row);
      else plain.push(row);
    }
    return { plain, zero, without };
  }

  remarks({ plain, zero, without }, metric) {
    const hollow = plain.filter((row) => row.missing.length);
    return [
      hollow.length ? `Hollow: ${counted(hollow.length, "mode")} without every scene, left out of the front. ` : "",
      zero.length ? `On the lowest line: ${zero.length} without any error. ` : "",
      without.length ? `Not shown, for want of ${this.wanted()} or of a ${metric.label}: ${without.length > 8 ? counted(without.length, "mode") : without.map(readable).join("; ")}. ` : "",
    ].filter((text) => text).map((text) => h("span", {}, text));
  }

  wanted() {
    return state.cost === "cpu" ? "a time that could be told" : `a number of ${this.cost.name}`;
  }

  drawAxes(metric, { zero }) {
    const [left, right, top, bottom] = [plotMargin.left, this.width - plotMargin.right, plotMargin.top, this.bottom];
    const grid = s("g", { class: "grid" });
    const labels = s("g", { class: "ticks" });
    for (const tick of ticksOf(this.x)) {
      const x = this.x.at(tick.value);
      grid.append(s("line", { x1: x, x2: x, y1: top, y2: bottom, class: tick.strong ? "strong" : "weak" }));
      if (tick.labelled) labels.append(s("text", { x, y: this.height - plotMargin.bottom + 16, "text-anchor": "middle" }, tickText(tick.value)));
    }
    for (const tick of ticksOf(this.y)) {
      const y = this.y.at(tick.value);
      grid.append(s("line", { x1: left, x2: right, y1: y, y2: y, class: tick.strong ? "strong" : "weak" }));
      const text = metric.linear ? minus(String(Number(metric.value(tick.value).toPrecision(4)))) : tickText(tick.value);
      if (tick.labelled ?? true) labels.append(s("text", { x: left - 8, y: y + 4, "text-anchor": "end" }, text));
    }
    if (zero.length) {
      const y = this.height - plotMargin.bottom - 6;
      grid.append(s("line", { x1: left, x2: right, y1: y, y2: y, class: "strong" }));
      labels.append(s("text", { x: left - 8, y: y + 4, "text-anchor": "end" }, metric.linear ? "∞" : "0"));
    }
    this.drawEfficiencies(grid, metric);
    this.svg.append(grid, labels,
      s("text", { x: left, y: 14, class: "axis-title" }, `${metric.plotted} against the reference`),
      s("text", { x: right, y: this.height - 6, class: "axis-title", "text-anchor": "end" }, this.cost.axis));
  }

  /** Lines of equal efficiency, a factor of 100 apart: along them, error falls as plain Monte Carlo's. */
  drawEfficiencies(grid, metric) {
    if (metric.name !== "rmse" || state.cost !== "cpu") return;
    const [x0, x1] = [10 ** this.x.low, 10 ** this.x.high];
    const [y0, y1] = [10 ** this.y.low, 10 ** this.y.high];
    const highest = Math.ceil(-Math.log10(y0 * y0 * x0) / 2) * 2;
    let named = false;
    for (let power = highest; power >= -Math.log10(y1 * y1 * x1); power -= 2) {
      const timeAt = (error) => 10 ** -power / (error * error);
      const start = Math.max(x0, timeAt(y1));
      const end = Math.min(x1, timeAt(y0));
      if (!(start < end)) continue;
      const errorAt = (time) => Math.sqrt(10 ** -power / time);
      const [ax, ay, bx, by] = [this.x.at(start), this.y.at(errorAt(start)), this.x.at(end), this.y.at(errorAt(end))];
      grid.append(s("line", { x1: ax, y1: ay, x2: bx, y2: by, class: "efficiency" }));
      const angle = (Math.atan2(by - ay, bx - ax) * 180) / Math.PI;
      if (!named && this.width > 560 && Math.hypot(bx - ax, by - ay) > 220) {
        named = true;
        grid.append(s("text", { transform: `translate(${bx} ${by}) rotate(${angle})`, x: -8, y: -4, "text-anchor": "end" }, "equal efficiency"));
      }
    }
  }

  /** The error of rounding to 8 bits, the natural end of the trade, where it is in sight. */
  drawQuantisation(metric) {
    const error = trade.quantisation;
    if (metric.name !== "rmse" || Math.log10(error) < this.y.low || Math.log10(error) > this.y.high) return;
    const y = this.y.at(error);
    const right = this.width - plotMargin.right;
    this.svg.append(s("g", { class: "quantisation" },
      s("line", { x1: plotMargin.left, x2: right, y1: y, y2: y }),
      s("text", { x: right - 2, y: y - 4, "text-anchor": "end" }, this.width < 480 ? "8 bits" : `rounding to 8 bits, ${figure(error)}`)));
  }

  drawFront(metric) {
    const front = paretoFront(this.rows, metric, this.cost.of).filter(({ badness }) => metric.linear ? badness > -Infinity : badness > 0);
    if (!front.length) return;
    const [first, ...rest] = front.map(({ time, badness }) => [this.x.at(time), this.y.at(badness)]);
    const steps = rest.map(([x, y]) => `H${x}V${y}`).join("");
    const path = `M${first[0]} ${plotMargin.top}V${first[1]}${steps}H${this.width - plotMargin.right}`;
    this.svg.append(s("path", { class: "front", d: path }, s("title", {}, "Pareto front: no mode is both cheaper and better")));
  }

  drawFamilies(rows, metric) {
    const families = new Map();
    for (const row of rows) {
      const key = `${row.renderer}\n${row.family}`;
      families.set(key, [...(families.get(key) ?? []), row]);
    }
    for (const [key, members] of families) {
      members.sort((a, b) => a.spp - b.spp || this.cost.of(a)[0] - this.cost.of(b)[0]);
      const colour = colourOf(members[0].renderer);
      const group = s("g", { class: "family", "data-family": key, stroke: colour });
      const places = members.map((row) => `${this.x.at(this.cost.of(row)[0])} ${this.y.at(badnessOf(row, metric))}`);
      group.append(s("path", { class: "line", d: `M${places.join("L")}` }));
      for (const row of members) group.append(...this.errorBars(row, metric));
      this.svg.append(group);
    }
  }

  errorBars(row, metric) {
    const [, error] = estimateOf(row, metric.name);
    const [time, timeError] = this.cost.of(row);
    const badness = badnessOf(row, metric);
    const [x, y] = [this.x.at(time), this.y.at(badness)];
    const bars = [];
    const least = (value, spread, linear) => (linear || value > spread ? value - spread : value * 1e-3);
    if (error) {
      const low = Math.min(this.bottom, this.y.at(least(badness, error, metric.linear)));
      bars.push(s("line", { class: "bar", x1: x, x2: x, y1: low, y2: Math.max(plotMargin.top, this.y.at(badness + error)) }));
    }
    if (timeError) {
      const low = Math.max(plotMargin.left, this.x.at(least(time, timeError, false)));
      bars.push(s("line", { class: "bar", y1: y, y2: y, x1: low, x2: Math.min(this.width - plotMargin.right, this.x.at(time + timeError)) }));
    }
    return bars;
  }

  drawPoints({ plain, zero }, metric) {
    const rail = this.height - plotMargin.bottom - 6;
    const places = [
      ...plain.map((row) => ({ row, x: this.x.at(this.cost.of(row)[0]), y: this.y.at(badnessOf(row, metric)) })),
      ...zero.map((row) => ({ row, x: this.x.at(this.cost.of(row)[0]), y: rail })),
    ].sort((a, b) => a.x - b.x);
    for (const place of places) {
      const { row } = place;
      const colour = colourOf(row.renderer);
      const label = `${readable(row)}: ${metricText(row, metric)}, ${figure(this.cost.of(row)[0])} ${this.cost.unit}`;
      const chance = this.chance(row);
      place.node = s(
        "g",
        {
          class: row.missing.length ? "point hollow" : "point", role: "button", tabindex: "-1", "aria-label": label,
          "data-renderer": row.renderer, "data-mode": row.mode, "data-family": `${row.renderer}\n${row.family}`,
          transform: `translate(${place.x} ${place.y})`,
          focus: () => this.showTip(place), blur: () => this.showTip(null),
        },
        chance ? s("circle", { class: "chance", r: 7.5, "stroke-opacity": chance }) : "",
        s("path", row.missing.length ? { d: shapeOf(row), stroke: colour } : { d: shapeOf(row), fill: colour }),
      );
      this.svg.append(place.node);
    }
    this.points = places;
    if (places.length) places[0].node.setAttribute("tabindex", "0");
  }

  /** The probability of a row's being on the front that is drawn: it is known of RMSE and time. */
  chance(row) {
    return this.metric.name === "rmse" && state.cost === "cpu" ? chanceOf(this.rows, row) : null;
  }

  /** Rings and letters around A and B. */
  mark() {
    if (!this.marks) return;
    this.marks.replaceChildren();
    for (const slot of ["a", "b"]) {
      const place = this.points.find(({ row }) => identity(row) === state[slot]);
      if (!place) continue;
      const under = place.y < plotMargin.top + 30;
      this.marks.append(
        s("circle", { cx: place.x, cy: place.y, r: slot === "a" ? 8.5 : 10.5 }),
        s("text", { x: place.x + (slot === "a" ? -5 : 5), y: place.y + (under ? 24 : -14), "text-anchor": "middle" }, slot.toUpperCase()),
      );
    }
  }

  nearest(event) {
    const box = this.svg.getBoundingClientRect();
    const unit = this.width / box.width;
    const [x, y] = [(event.clientX - box.left) * unit, (event.clientY - box.top) * unit];
    let best = null;
    let least = 26;
    for (const place of this.points) {
      const distance = Math.hypot(place.x - x, place.y - y);
      if (distance < least && !this.hidden.has(place.node.dataset.family)) [best, least] = [place, distance];
    }
    return best;
  }

  hover(event) {
    this.showTip(this.nearest(event));
  }

  pick(event) {
    const place = this.nearest(event);
    if (place) this.open(event, place);
  }

  /** A click opens a mode beside the reference, and shows them; with shift it becomes B. */
  open(event, { row }) {
    if (event.shiftKey) choose("b", identity(row));
    else if (choose("a", identity(row), { b: referenceName })) showPictures();
  }

  key(event) {
    const now = this.points.findIndex(({ node }) => node === document.activeElement);
    if (now < 0) return;
    const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };
    if (event.key in steps) {
      const next = this.points[clamp(now + steps[event.key], 0, this.points.length - 1)];
      this.points[now].node.setAttribute("tabindex", "-1");
      next.node.setAttribute("tabindex", "0");
      next.node.focus();
    } else if (event.key === "Enter" || event.key === " ") {
      this.open(event, this.points[now]);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  showTip(place) {
    this.tip.hidden = !place;
    this.svg.classList.toggle("hit", Boolean(place));
    if (!place) return;
    const { row } = place;
    const line = (name, value) => (value ? h("div", {}, h("dt", {}, name), h("dd", {}, value)) : null);
    const [value, error] = estimateOf(row, this.metric.name);
    const chance = this.chance(row);
    const ends = endsOf(row.cpu);
    this.tip.replaceChildren(
      h("p", {}, marker(row), " ", h("b", {}, row.renderer), " ", modeName(row)),
      h("dl", {},
        line(this.metric.title, `${estimated(value, error)} ${uncertainty(value, error)}`),
        line("CPU seconds", timeFigure(row.cpu[0])),
        line("", ends && rangeText(...ends)),
        line("samples a pixel", figure(row.spp)),
        line("rays a pixel", state.cost === "rays" && row.rays && figure(row.rays)),
        line("instructions", state.cost === "instructions" && row.instructions && figure(row.instructions)),
        line("on the front", chance !== null && percent(chance)),
        line("efficiency", figure(efficiencyOf(row)[0])),
        line("lacks", row.missing.join("; "))),
      h("p", { class: "hint" }, "click: see it beside the reference · shift-click: as B"),
    );
    const unit = this.svg.getBoundingClientRect().width / this.width;
    const [x, y] = [place.x * unit, place.y * unit];
    const [w, tall] = [this.tip.offsetWidth, this.tip.offsetHeight];
    const left = x + 16 + w > this.svg.clientWidth ? x - 16 - w : x + 16;
    this.tip.style.left = `${Math.max(0, Math.min(left, this.svg.clientWidth - w))}px`;
    this.tip.style.top = `${Math.max(0, y - tall / 2)}px`;
  }

  /** Shows one family before the others; null shows all alike. */
  emphasise(family) {
    this.svg.classList.toggle("emphasis", family !== null);
    for (const node of this.svg.querySelectorAll("[data-family]")) {
      node.classList.toggle("emphasised", node.dataset.family === family);
    }
  }

  applyHidden() {
    for (const node of this.svg.querySelectorAll("[data-family]")) {
      node.classList.toggle("gone", this.hidden.has(node.dataset.family));
    }
  }
}
