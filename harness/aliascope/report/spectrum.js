// The error as a signal: the power of A's and of B's by frequency, and the number that tells a pattern from noise.

const spectrumMargin = { top: 34, right: 26, bottom: 40, left: 52 };
const nyquist = 0.5; // cycles per pixel along an axis; beyond, only diagonals are left
const mostDecades = 8;
const hiddenShare = 0.01; // of all powers of a scene, the least: they would take the room of the others

/** A row's powers by frequency; a sentence where it has none. */
function spectrumOf(scene, row) {
  return row ? scene.spectra.rows[scene.rows.indexOf(row)] : "is the reference: no error";
}

const hasSpectrum = (powers) => typeof powers !== "string";

class Spectrum {
  constructor(host, scene) {
    this.host = h("div", { class: "figure" });
    this.scene = scene;
    this.at = null;
    this.svg = s("svg", {
      class: "plot spectrum-plot", role: "slider", tabindex: "0", "aria-label": `${scene.name}: frequency of the error, in cycles per pixel`,
      "aria-valuemin": 0, "aria-valuemax": Math.max(0, scene.spectra.frequencies.length - 1),
      pointermove: (event) => this.hover(event), pointerleave: () => this.read(null),
      keydown: (event) => this.key(event), blur: () => this.read(null),
    });
    this.tip = h("div", { class: "tip", hidden: true });
    this.note = h("figcaption", { class: "note" });
    this.strip = s("svg", { class: "strip", viewBox: "0 0 340 58", "aria-hidden": "true" });
    this.body = h("tbody");
    this.host.append(h("figure", {}, h("div", { class: "plot-box" }, this.svg, this.tip), this.note));
    host.append(h("div", { class: "spectrum" }, this.host, this.numbers()));
    new ResizeObserver(() => {
      if (this.host.clientWidth && this.host.clientWidth !== this.width) this.draw();
    }).observe(this.host);
  }

  numbers() {
    const head = ["picture", "structure", "uncertainty"].map((text, i) =>
      h("th", { scope: "col", class: i ? "number" : null }, h("span", { class: "hidden" }, text)));
    return h("div", { class: "structure" },
      h("h4", {}, "Noise or a pattern?"),
      h("p", {}, h("b", {}, "structure"), " tells how much neighbouring errors go together: near 0, noise; toward ½, a pattern (moiré, staircases)."),
      this.strip,
      h("table", {}, h("caption", { class: "hidden" }, "Structure of the error of A and B"), h("thead", {}, h("tr", {}, head)), this.body),
      h("p", { class: "note" }, "Noise has a flat spectrum, a pattern has peaks. Moiré whose frequency changes over the picture spreads over the spectrum as noise does: then the number alone tells."));
  }

  /** One scale for all pictures of the scene, so that curves can be compared as A and B change. */
  draw() {
    const { frequencies, rows } = this.scene.spectra;
    this.width = this.host.clientWidth || 640;
    this.height = clamp(Math.round(this.width * 0.44), 260, 400);
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    this.svg.replaceChildren();
    this.front = null;
    const known = rows.filter(hasSpectrum);
    const positive = known.flat().filter((power) => power > 0);
    this.svg.toggleAttribute("hidden", !positive.length);
    if (positive.length) {
      positive.sort((a, b) => a - b);
      const high = positive[positive.length - 1];
      const low = Math.max(positive[Math.floor(positive.length * hiddenShare)], high * 10 ** -mostDecades);
      const bottom = this.height - spectrumMargin.bottom;
      const [left, right] = [spectrumMargin.left, this.width - spectrumMargin.right];
      const highest = Math.max(nyquist, frequencies[frequencies.length - 1]);
      this.x = { at: (f) => left + (f / highest) * (right - left), from: left, to: right, highest };
      this.y = axisScale([low, high], bottom, spectrumMargin.top, false);
      this.drawAxes(bottom);
      const others = s("g", { class: "others" });
      rows.forEach((powers, i) => {
        if (hasSpectrum(powers)) others.append(s("path", { d: this.path(powers), stroke: colourOf(this.scene.rows[i].renderer) }));
      });
      this.front = s("g", {});
      this.letters = s("g", {});
      this.cursor = s("line", { class: "cursor", y1: spectrumMargin.top, y2: bottom, visibility: "hidden" });
      const frame = s("svg", { width: this.width, height: bottom }, others, this.front); // clips what it holds
      this.svg.append(frame, this.cursor, this.letters);
    }
    this.mark();
  }

  drawAxes(bottom) {
    const { from: left, to: right, highest } = this.x;
    const grid = s("g", { class: "grid" });
    const labels = s("g", { class: "ticks" });
    const limit = this.x.at(nyquist);
    grid.append(s("rect", { class: "beyond", x: limit, y: spectrumMargin.top, width: right - limit, height: bottom - spectrumMargin.top }));
    for (let i = 0; i / 10 <= highest + 1e-9; i++) {
      const x = this.x.at(i / 10);
      grid.append(s("line", { x1: x, x2: x, y1: spectrumMargin.top, y2: bottom, class: i === 5 ? "limit" : "weak" }));
      labels.append(s("text", { x, y: bottom + 16, "text-anchor": "middle" }, String(i / 10)));
    }
    for (const tick of ticksOf(this.y)) {
      const y = this.y.at(tick.value);
      if (!tick.strong && this.y.high - this.y.low > 3) continue;
      grid.append(s("line", { x1: left, x2: right, y1: y, y2: y, class: tick.strong ? "strong" : "weak" }));
      if (tick.labelled) labels.append(s("text", { x: left - 8, y: y + 4, "text-anchor": "end" }, tickText(tick.value)));
    }
    this.svg.append(grid, labels,
      s("text", { x: left, y: 14, class: "axis-title" }, "Power of the error by its frequency"),
      s("text", { x: limit - 5, y: spectrumMargin.top + 12, "text-anchor": "end" }, "Nyquist"),
      s("text", { x: right, y: this.height - 6, class: "axis-title", "text-anchor": "end" }, "cycles per pixel"));
  }

  /** Powers below the plot, and 0, lie just under its frame, which clips them. */
  heightOf(power) {
    return Math.min(this.y.at(Math.max(power, Number.MIN_VALUE)), this.y.from + 50);
  }

  path(powers) {
    return `M${powers.map((power, i) => `${this.x.at(this.scene.spectra.frequencies[i]).toFixed(1)} ${this.heightOf(power).toFixed(1)}`).join("L")}`;
  }

  /** The mean over all frequencies: where the curve would lie, were the error white noise of the same power. */
  level(powers) {
    const { bins } = this.scene.spectra;
    const total = bins.reduce((a, b) => a + b);
    return powers.reduce((sum, power, i) => sum + bins[i] * power, 0) / total;
  }

  /** A and B, the curves and the numbers. */
  mark() {
    const pair = pairIn(this.scene);
    this.pair = ["a", "b"].map((slot) => {
      const row = rowOf(this.scene, pair[slot]);
      return { slot, letter: slot.toUpperCase(), row, powers: spectrumOf(this.scene, row) };
    });
    if (this.front) this.drawPair(this.pair.filter(({ powers }) => hasSpectrum(powers)));
    const without = this.pair.filter(({ powers }) => !hasSpectrum(powers));
    this.note.replaceChildren(
      ...without.map(({ letter, powers }) => h("span", { class: "without" }, `${letter} ${powers}. `)),
      this.front ? "A solid, B dashed; faint: the other modes. Dotted: the same power spread evenly, as white noise has it." : "");
    this.drawStrip();
    this.body.replaceChildren(...this.pair.map((entry) => this.line(entry)));
    this.read(this.at);
  }

  drawPair(shown) {
    this.front.replaceChildren();
    const ends = [];
    for (const { slot, letter, row, powers } of shown) {
      const level = this.heightOf(this.level(powers));
      const stroke = colourOf(row.renderer);
      this.front.append(s("g", { class: `curve ${slot}`, "data-slot": slot, "data-mode": identity(row), stroke },
        s("line", { class: "level", x1: this.x.from, x2: this.x.to, y1: level, y2: level }),
        s("path", { class: "line", d: this.path(powers) }, s("title", {}, `${letter}: ${readable(row)}`))));
      ends.push({ letter, y: Math.min(this.heightOf(powers[powers.length - 1]), this.y.from) });
    }
    if (ends.length === 2 && Math.abs(ends[0].y - ends[1].y) < 14) {
      const [upper, lower] = ends[0].y <= ends[1].y ? ends : [ends[1], ends[0]];
      const middle = (upper.y + lower.y) / 2;
      [upper.y, lower.y] = [middle - 7, middle + 7];
    }
    this.letters.replaceChildren(...ends.map(({ letter, y }) => s("text", { class: "letter", x: this.x.to + 7, y: y + 4.5 }, letter)));
  }

  /** Where the two numbers lie between noise and a pattern. */
  drawStrip() {
    const at = (value) => 8 + clamp(value, 0, 1) * 324;
    const words = [[0, "0 noise", "start", 0], [0.5, "½ pattern", "middle", at(0.5)], [1, "1 constant", "end", 340]];
    this.strip.replaceChildren(
      s("line", { class: "rail", x1: at(0), x2: at(1), y1: 28, y2: 28 }),
      ...words.map(([value]) => s("line", { class: "rail", x1: at(value), x2: at(value), y1: 24, y2: 32 })),
      ...words.map(([, text, anchor, x]) => s("text", { x, y: 52, "text-anchor": anchor }, text)));
    const places = this.pair
      .filter(({ row }) => row && estimateOf(row, "structure")[0] !== null)
      .map(({ letter, row }) => ({ letter, row, x: at(estimateOf(row, "structure")[0]) }));
    const close = places.length === 2 && Math.abs(places[0].x - places[1].x) < 13;
    const side = (i) => (close ? ((places[i].x <= places[1 - i].x) === (i === 0) ? (i === 0 ? -7 : 7) : i === 0 ? 7 : -7) : 0);
    places.forEach(({ letter, row, x }, i) => this.strip.append(
      s("path", { transform: `translate(${x} 28)`, d: shapeOf(row), fill: colourOf(row.renderer) }),
      s("text", { class: "letter", x: Math.max(5, x + side(i)), y: 16, "text-anchor": "middle" }, letter)));
  }

  line({ slot, letter, row }) {
    const [value, error] = row ? estimateOf(row, "structure") : [null, null];
    const name = row ? [marker(row), " ", h("b", {}, row.renderer), " ", modeName(row)] : "reference";
    return h("tr", { "data-structure": slot },
      h("th", { scope: "row" }, h("span", { class: "badge" }, letter), " ", name),
      h("td", { class: "number" }, figure(value)),
      h("td", { class: "spread" }, value === null ? "" : uncertainty(value, error)));
  }

  // A frequency read out: under the pointer, or walked to with the arrows.

  hover(event) {
    if (!this.front) return;
    const box = this.svg.getBoundingClientRect();
    const x = (event.clientX - box.left) * (this.width / box.width);
    const apart = this.scene.spectra.frequencies.map((f) => Math.abs(this.x.at(f) - x));
    this.read(x < this.x.from - 10 ? null : apart.indexOf(Math.min(...apart)));
  }

  key(event) {
    const last = this.scene.spectra.frequencies.length - 1;
    const now = this.at ?? -1;
    const to = { ArrowRight: now + 1, ArrowUp: now + 1, ArrowLeft: now - 1, ArrowDown: now - 1, Home: 0, End: last }[event.key];
    if (to === undefined || !this.front) return;
    this.read(clamp(to, 0, last));
    event.preventDefault();
    event.stopPropagation();
  }

  read(index) {
    this.at = this.front ? index : null;
    this.tip.hidden = this.at === null;
    this.cursor?.setAttribute("visibility", this.at === null ? "hidden" : "visible");
    const frequency = this.scene.spectra.frequencies[this.at ?? 0];
    const powers = this.pair.filter(({ powers: p }) => hasSpectrum(p)).map(({ letter, row, powers: p }) => ({ letter, row, power: p[this.at ?? 0] }));
    const texts = powers.map(({ letter, power }) => `${letter} ${figure(power)}`);
    this.svg.setAttribute("aria-valuenow", String(this.at ?? 0));
    this.svg.setAttribute("aria-valuetext", this.front ? `${figure(frequency)} cycles per pixel: power ${texts.join(", ")}` : "no spectrum");
    if (this.at === null) return;
    this.tip.replaceChildren(
      h("p", {}, h("b", {}, figure(frequency)), ` cycles per pixel, period ${figure(1 / frequency, 2)} px`),
      h("dl", {}, powers.map(({ letter, row, power }) => h("div", {}, h("dt", {}, marker(row), ` ${letter}`), h("dd", {}, figure(power))))));
    const x = this.x.at(frequency);
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
    const unit = this.svg.getBoundingClientRect().width / this.width;
    const wide = this.tip.offsetWidth;
    const left = x * unit + 14 + wide > this.svg.clientWidth ? x * unit - 14 - wide : x * unit + 14;
    this.tip.style.left = `${Math.max(0, left)}px`;
    this.tip.style.top = `${spectrumMargin.top * unit}px`;
  }
}
