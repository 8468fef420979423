// What the reconstruction filters let through: one small plot each, the others faint behind it, one scale for all.

const panelSize = { width: 300, height: 172, top: 8, right: 6, bottom: 26, left: 28 };
const lowestAmplitude = -0.3;
const highestAmplitude = 1.1;
const telling = [0.25, 0.5, 0.75, 1, 1.5]; // among the frequencies that `filters.py` gives

class Filters {
  constructor(host, { frequencies, responses }) {
    Object.assign(this, { frequencies, responses });
    this.panels = responses.map((response) => this.panel(response));
    host.append(
      h("ul", { class: "panels", pointermove: (event) => this.hover(event), pointerleave: () => this.read(null) }, this.panels.map(({ node }) => node)),
      h("details", {}, h("summary", {}, "Amplitudes as a table"), this.table()));
  }

  x(frequency) {
    const { left, right, width } = panelSize;
    return left + (frequency / this.frequencies[this.frequencies.length - 1]) * (width - left - right);
  }

  y(amplitude) {
    const { top, bottom, height } = panelSize;
    return height - bottom - ((amplitude - lowestAmplitude) / (highestAmplitude - lowestAmplitude)) * (height - top - bottom);
  }

  path({ amplitude }) {
    return `M${amplitude.map((a, i) => `${this.x(this.frequencies[i]).toFixed(1)} ${this.y(a).toFixed(1)}`).join("L")}`;
  }

  at(response, frequency) {
    return response.amplitude[this.frequencies.indexOf(frequency)];
  }

  panel(response) {
    const { top, bottom, width, height, left, right } = panelSize;
    const limit = this.x(nyquist);
    const value = h("output", { class: "value" });
    const cursor = s("line", { class: "cursor", y1: top, y2: height - bottom, visibility: "hidden" });
    const dot = s("circle", { r: 3, visibility: "hidden" });
    const label = `${response.name}: amplitude ${figure(this.at(response, nyquist))} at the Nyquist frequency, ${figure(this.at(response, 1))} at 1 cycle per pixel`;
    const svg = s("svg", { class: "plot response", viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label },
      s("g", { class: "grid" },
        s("rect", { class: "beyond", x: limit, y: top, width: width - right - limit, height: height - top - bottom }),
        [0, 1].map((a) => s("line", { class: a ? "weak" : "strong", x1: left, x2: width - right, y1: this.y(a), y2: this.y(a) })),
        s("line", { class: "limit", x1: limit, x2: limit, y1: top, y2: height - bottom })),
      s("g", { class: "ticks" },
        [0, 1].map((a) => s("text", { x: left - 6, y: this.y(a) + 4, "text-anchor": "end" }, String(a))),
        [0, 0.5, 1, 1.5, 2].map((f) => s("text", { x: this.x(f), y: height - bottom + 15, "text-anchor": f === 2 ? "end" : "middle" }, String(f)))),
      s("g", { class: "others" }, this.responses.filter((other) => other !== response).map((other) => s("path", { d: this.path(other) }))),
      s("path", { class: "line", d: this.path(response) }), cursor, dot);
    const node = h("li", { "data-filter": response.name },
      h("p", { class: "panel-head" }, h("b", {}, response.name), value),
      svg,
      h("p", { class: "note", title: response.source }, `${response.title}; radius ${response.radius} px`));
    return { response, node, svg, cursor, dot, value };
  }

  /** The same frequency in every plot. */
  hover(event) {
    const panel = this.panels.find(({ svg }) => svg.contains(event.target));
    if (!panel) {
      this.read(null);
      return;
    }
    const box = panel.svg.getBoundingClientRect();
    const share = ((event.clientX - box.left) * (panelSize.width / box.width) - panelSize.left) / (panelSize.width - panelSize.left - panelSize.right);
    const index = Math.round(clamp(share, 0, 1) * (this.frequencies.length - 1));
    this.read(index);
  }

  read(index) {
    for (const { response, cursor, dot, value } of this.panels) {
      for (const node of [cursor, dot]) node.setAttribute("visibility", index === null ? "hidden" : "visible");
      value.textContent = index === null ? "" : `${minus(response.amplitude[index].toFixed(3))} at ${this.frequencies[index].toFixed(3)}`;
      if (index === null) continue;
      const x = this.x(this.frequencies[index]);
      cursor.setAttribute("x1", x);
      cursor.setAttribute("x2", x);
      dot.setAttribute("cx", x);
      dot.setAttribute("cy", this.y(response.amplitude[index]));
    }
  }

  table() {
    const head = ["Filter", "Radius, px", ...telling.map((f) => `at ${f}`)];
    return h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Amplitudes of the filters" },
      h("table", { class: "plain" },
        h("caption", { class: "hidden" }, "Amplitude of each filter at some frequencies, in cycles per pixel"),
        h("thead", {}, h("tr", {}, head.map((text, i) => h("th", { scope: "col", class: i ? "number" : null }, text)))),
        h("tbody", {}, this.responses.map((response) => h("tr", {},
          h("th", { scope: "row" }, response.name),
          h("td", { class: "number" }, String(response.radius)),
          telling.map((f) => h("td", { class: "number" }, minus(this.at(response, f).toFixed(3)))))))));
  }
}
