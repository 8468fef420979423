// Beside the pictures: what A and B are, how they are shown, and what the values of a pixel are.

const scaleSteps = [1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 1e-4, 1e-5];

const helpOfKeys = [
  ["1 … 9", "mode of that row of the table as A; with shift as B"],
  ["← ↑ → ↓", "walk the pixel; with shift by ten"],
  ["space", "blink; again: the other picture"],
  ["e", "error A, error B, both, none"],
  ...(withSamples ? [["s", "how many samples each pixel of A took, and back"]] : []),
  ...(withTests ? [["p", "the p-values of A, and back"]] : []),
  ["r", "the reference as A, and back"],
  ["m", "to the largest error of A; with shift of B"],
  ["+  −  0", "zoom in, out, fit"],
];

class Controls {
  constructor(viewer) {
    this.viewer = viewer;
    this.selects = { a: this.select("a"), b: this.select("b") };
    this.views = views.map((view) => {
      const radio = h("input", { type: "radio", name: "view", value: view, change: () => change({ view }) });
      return { view, radio, node: h("label", {}, radio, h("span", {}, viewNames[view])) };
    });
    this.play = h("button", { type: "button", class: "small", click: () => this.togglePlay() });
    this.exposure = h("input", {
      type: "range", min: -8, max: 8, step: 0.5, "aria-label": "exposure in stops",
      input: () => change({ exposure: Number(this.exposure.value) }),
    });
    this.exposureText = h("output");
    this.zoomText = h("output");
    this.scale = h("select", { "aria-label": "end of the error scale", change: () => this.setScale() });
    this.place = h("output", { class: "place" });
    this.values_ = h("tbody");
    this.differences = h("tbody");
    this.readout = h("div", { class: "readout" },
      this.readTable("Linear values", this.values_), this.readTable("Difference from the reference", this.differences));
    this.node = h("div", { class: "controls" }, this.parts());
  }

  parts() {
    const button = (text, label, act) => h("button", { type: "button", class: "small", "aria-label": label, title: label, click: act }, text);
    const { viewer } = this;
    return [
      h("div", { class: "pickers" }, ["a", "b"].map((slot) =>
        h("label", {}, h("span", { class: `badge ${slot}` }, slot.toUpperCase()), this.selects[slot]))),
      h("fieldset", { class: "views" }, h("legend", { class: "hidden" }, "View"), this.views.map(({ node }) => node), this.play),
      h("div", { class: "dials" },
        h("label", { class: "dial" }, h("span", {}, "exposure"), this.exposure, this.exposureText),
        h("div", { class: "dial" }, h("span", {}, "zoom"),
          h("span", { class: "buttons" },
            button("−", "zoom out", () => viewer.zoomBy(-1)), button("+", "zoom in", () => viewer.zoomBy(1)),
            button("fit", "fit the picture", () => viewer.fit())), this.zoomText),
        h("label", { class: "dial" }, h("span", {}, "errors to"), this.scale),
        h("div", { class: "dial" }, h("span", {}, "go to"),
          h("span", { class: "buttons" },
            button("worst of A", "to the largest error of A", () => viewer.worst("a")),
            button("of B", "to the largest error of B", () => viewer.worst("b"))))),
      h("details", { class: "keys" }, h("summary", {}, "Keys"),
        h("dl", {}, helpOfKeys.map(([key, text]) => h("div", {}, h("dt", {}, h("kbd", {}, key)), h("dd", {}, text)))),
        h("p", { class: "note" }, "Arrows and space act while the pictures have the focus or the pointer.")),
    ];
  }

  readTable(title, body) {
    const head = h("tr", {}, h("th", { scope: "col" }, title === "Linear values" ? this.place : h("span", { class: "hidden" }, "picture")),
      ["R", "G", "B"].map((name) => h("th", { scope: "col", class: "number" }, name)));
    return h("table", {}, h("caption", {}, title), h("thead", {}, head), body);
  }

  select(slot) {
    const node = h("select", { "aria-label": `picture ${slot.toUpperCase()}`, "data-slot": slot, change: () => choose(slot, node.value) });
    return node;
  }

  fillSelects(scene) {
    for (const node of Object.values(this.selects)) {
      const groups_ = documentData.renderers.map((renderer) => {
        const rows = scene.rows.filter((row) => row.renderer === renderer);
        return rows.length ? h("optgroup", { label: renderer }, rows.map((row) => h("option", { value: identity(row) }, readable(row)))) : null;
      });
      node.replaceChildren(h("option", { value: referenceName }, "reference"), ...groups_.filter(Boolean));
    }
    const usual = scene.scale;
    const steps = scaleSteps.filter((step) => step !== usual);
    this.scale.replaceChildren(h("option", { value: "" }, `±${roundFigure(usual)} (of the scene)`), ...steps.map((step) => h("option", { value: String(step) }, `±${roundFigure(step)}`)));
    this.filled = scene;
  }

  setScale() {
    change({ scale: this.scale.value === "" ? null : Number(this.scale.value) });
  }

  togglePlay() {
    this.viewer.playing = !this.viewer.playing;
    this.viewer.paint();
  }

  show(layout) {
    const scene = currentScene();
    if (this.filled !== scene) this.fillSelects(scene);
    for (const [slot, node] of Object.entries(this.selects)) node.value = state[slot];
    for (const { view, radio } of this.views) radio.checked = view === state.view;
    this.play.hidden = state.view !== "blink";
    this.play.textContent = this.viewer.playing ? "pause" : "play";
    this.exposure.value = state.exposure;
    this.exposureText.textContent = `${state.exposure > 0 ? "+" : ""}${minus(String(state.exposure))} EV`;
    this.zoomText.textContent = `${layout.zoom}×`;
    if (state.scale && ![...this.scale.options].some((option) => option.value === String(state.scale))) {
      this.scale.append(h("option", { value: String(state.scale) }, `±${roundFigure(state.scale)}`));
    }
    this.scale.value = state.scale ? String(state.scale) : "";
  }

  /** The linear values of a pixel, and what A and B are off by. */
  read({ x, y, taken, surprise, reference, a, b }) {
    this.values = { x, y, reference, a, b };
    this.place.textContent = `pixel (${x}, ${y})`;
    const chip = (values) => {
      const node = h("span", { class: "chip", "aria-hidden": "true" });
      node.style.backgroundColor = values.every(Number.isFinite)
        ? `rgb(${values.map((v) => srgbByte(v * 2 ** state.exposure)).join(" ")})` : `rgb(${notFinite.join(" ")})`;
      return node;
    };
    const line = (name, key, values, signed, swatch) =>
      h("tr", { "data-read": key, class: signed ? "difference" : null }, h("th", { scope: "row" }, swatch, name),
        values.map((v) => h("td", { class: "number" }, pixelValue(v, signed))));
    const off = (values) => values.map((value, i) => value - reference[i]);
    this.values_.replaceChildren(
      line("reference", "reference", reference, false, chip(reference)),
      line("A", "a", a, false, chip(a)),
      line("B", "b", b, false, chip(b)));
    if (withSamples && Number.isFinite(taken)) {
      this.values_.append(h("tr", { "data-read": "taken" }, h("th", { scope: "row" }, "A took"),
        h("td", { class: "number", colspan: 3 }, counted(Number(taken.toPrecision(4)), "sample"))));
    }
    if (Number.isFinite(surprise)) {
      this.values_.append(h("tr", { "data-read": "p-value" }, h("th", { scope: "row" }, "A's p-value"),
        h("td", { class: "number", colspan: 3 }, pValueText(surprise))));
    }
    this.differences.replaceChildren(
      ...[["a", a], ["b", b]].map(([slot, values]) => line(`${slot.toUpperCase()} − ref`, `${slot}-error`, off(values), true, null)));
  }

  /** Tells a screen reader the pixel that was walked to. */
  say() {
    if (!this.values) return;
    const text = (values) => values.map((value) => pixelValue(value)).join(" ");
    const { x, y, reference, a, b } = this.values;
    announce(`pixel ${x}, ${y}: reference ${text(reference)}; A ${text(a)}; B ${text(b)}`);
  }
}
