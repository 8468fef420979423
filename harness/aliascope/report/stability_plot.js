// Error against level, log-log: the bound and the precision as lines; what has no error has a place above the plot.

const room = { top: 50, right: 18, bottom: 42, left: 60 };

/** A logarithmic scale; 0, which has no logarithm, has a place of its own, one step before the least. */
function levelScale(levels, from, to, falling) {
  const above = levels.filter((level) => level > 0);
  const plain = above.length + levels.filter((level) => level === 0).length === levels.length && above.length > 0;
  if (!plain) { // negative levels, or nothing but 0: one after the other
    const order = [...new Set(levels)];
    const at = (level) => from + ((order.indexOf(level) + 0.5) / order.length) * (to - from);
    return { at, ticks: order.map((value) => ({ value, text: figure(value) })) };
  }
  let low = Math.log10(Math.min(...above));
  let high = Math.log10(Math.max(...above));
  const margin = Math.max(0.04 * (high - low), (1 - (high - low)) / 2, 0.02);
  [low, high] = [low - margin, high + margin];
  const zero = levels.includes(0);
  const shelf = zero ? 0.1 : 0; // the share of the axis that 0 has
  const place = (level) => (level === 0 ? shelf / 2 : shelf + (1 - shelf) * ((Math.log10(level) - low) / (high - low)));
  const at = (level) => from + (falling ? 1 - place(level) : place(level)) * (to - from);
  const ticks = decades(low, high, (to - from) / 62).map((power) => ({ value: Number(`1e${power}`), text: powerText(power) }));
  if (high - low < 1.5) ticks.push(...[2, 5].flatMap((digit) => decades(low - 1, high, 99).map((power) => Number(`${digit}e${power}`)))
    .filter((value) => Math.log10(value) > low && Math.log10(value) < high).map((value) => ({ value, text: figure(value, 1) })));
  if (zero) ticks.push({ value: 0, text: "0" });
  return { at, ticks };
}

/** Exponents within [low, high], at most as many as there is room for, at a round distance. */
function decades(low, high, most) {
  const span = Math.max(1, high - low);
  const stride = [1, 2, 3, 5, 10, 20, 50, 100].find((each) => span / each <= Math.max(2, most)) ?? 200;
  const found = [];
  for (let power = Math.ceil(low / stride) * stride; power <= high; power += stride) found.push(power);
  return found;
}

const powerText = (power) => (power >= -2 && power <= 3 ? String(Number(`1e${power}`)) : `10${superscript(power)}`);

const marks = {
  kept: ["kept", shapes[0], "within the bound"],
  over: ["over", shapes[3], "past the bound"],
  none: ["over", shapes[2], "no finite result"],
  refused: ["declined", shapes[1], "declined"],
  failed: ["crossed", "M-4.5-4.5 4.5 4.5M4.5-4.5-4.5 4.5", "failed"],
};

/** A figure that was chosen, without more digits than it has. */
const plainFigure = (value) => (value > 0 && Number(value.toPrecision(1)) === value ? roundFigure(value) : figure(value, 2));

const markOf = (reading) =>
  reading.failed ? "failed" : reading.refused ? "refused" : reading.error === "none" ? "none" : reading.over ? "over" : "kept";

const readingText = (reading) =>
  ({ failed: `failed: ${reading.failed}`, refused: `declined: ${reading.refused}`, none: "no finite result" })[markOf(reading)] ?? figure(reading.error);

class ReadingsPlot {
  constructor(host, cell) {
    this.cell = cell;
    this.width = Math.max(280, host.clientWidth || 640);
    this.height = clamp(Math.round(this.width * 0.45), 250, 380);
    this.svg = s("svg", { class: "plot readings-plot", role: "img", viewBox: `0 0 ${this.width} ${this.height}`, "aria-label": this.summary() });
    host.append(h("figure", {}, this.svg, this.key()));
    this.draw();
  }

  summary() {
    const { cell } = this;
    return `Error of ${cell.component} against ${cell.axis}: ${cell.told}. The table below has all readings.`;
  }

  key() {
    const used = [...new Set(this.cell.readings.map(markOf))];
    return h("p", { class: "plot-key", "aria-hidden": "true" }, Object.keys(marks).filter((name) => used.includes(name)).map((name) => {
      const [css, d, words] = marks[name];
      return h("span", {}, s("svg", { class: "marker", viewBox: "-7 -7 14 14", width: 14, height: 14 }, s("path", { class: css, d })), words);
    }));
  }

  draw() {
    const { svg, cell, width, height } = this;
    const rail = cell.readings.some((reading) => typeof reading.error !== "number");
    const [left, right, top] = [room.left, width - room.right, rail ? room.top : room.top - 20];
    const numbers = cell.readings.map((reading) => reading.error).filter((error) => typeof error === "number");
    const zeros = numbers.some((error) => error === 0) || cell.bound === 0;
    const bottom = height - room.bottom - (zeros ? 20 : 0);
    Object.assign(this, { left, right, top, bottom, rail: top - 17, floor: height - room.bottom - 8 });
    const values = [...numbers, cell.bound, cell.precision].filter((value) => value > 0).map(Math.log10);
    let [low, high] = [Math.min(...values), Math.max(...values)];
    const margin = Math.max(0.06 * (high - low), (2 - (high - low)) / 2);
    [low, high] = [low - margin, high + margin];
    this.y = (error) => (error === 0 ? this.floor : bottom + ((Math.log10(error) - low) / (high - low)) * (top - bottom));
    this.x = levelScale(cell.readings.map((reading) => reading.at), left + 8, right - 8, cell.falling);
    const grid = s("g", { class: "grid" });
    for (const power of decades(low, high, (bottom - top) / 30)) {
      const y = this.y(Number(`1e${power}`));
      grid.append(s("line", { class: "strong", x1: left, x2: right, y1: y, y2: y }), s("text", { x: left - 8, y: y + 4, "text-anchor": "end" }, powerText(power)));
    }
    if (zeros) grid.append(s("line", { class: "strong", x1: left, x2: right, y1: this.floor, y2: this.floor }), s("text", { x: left - 8, y: this.floor + 4, "text-anchor": "end" }, "0"));
    for (const { value, text } of this.x.ticks) {
      const x = this.x.at(value);
      grid.append(s("line", { class: "weak", x1: x, x2: x, y1: top, y2: bottom }), s("text", { x, y: height - room.bottom + 17, "text-anchor": "middle" }, text));
    }
    svg.append(grid, s("text", { class: "axis-title", x: 0, y: 13 }, `error, ${cell.unit}`),
      s("text", { class: "axis-title", x: right, y: height - 5, "text-anchor": "end" }, cell.axis));
    this.drawLine("precision", cell.precision, `precision ${figure(cell.precision, 2)}`, false);
    this.drawLine("bound", cell.bound, `bound ${plainFigure(cell.bound)}`, true);
    this.drawReadings();
  }

  drawLine(name, value, text, above) {
    const y = this.y(value);
    this.svg.append(s("line", { class: name, x1: this.left, x2: this.right, y1: y, y2: y }),
      s("text", { class: `${name}-text`, x: this.left + 6, y: above ? y - 6 : y + 14 }, text));
  }

  drawReadings() {
    const readings = this.cell.readings.map((reading) => ({ reading, x: this.x.at(reading.at), mark: markOf(reading) })).sort((a, b) => a.x - b.x);
    let course = "";
    let pen = "M";
    for (const { reading, x } of readings) {
      if (typeof reading.error !== "number") pen = "M";
      else {
        course += `${pen}${x} ${this.y(reading.error)}`;
        pen = "L";
      }
    }
    if (course) this.svg.append(s("path", { class: "course", d: course }));
    for (const { reading, x, mark } of readings) {
      const [css, d] = marks[mark];
      const y = typeof reading.error === "number" ? this.y(reading.error) : this.rail;
      if (mark === "refused" || mark === "failed") this.svg.append(s("line", { class: "refusal", x1: x, x2: x, y1: this.rail, y2: this.bottom }));
      this.svg.append(s("path", { class: css, d, transform: `translate(${x} ${y})` },
        s("title", {}, `${reading.level}: ${readingText(reading)}`)));
    }
  }
}
