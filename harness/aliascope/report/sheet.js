// The contact sheet of a scene: every picture beside the map of its error, all maps on one scale.

const thumbnailSide = 160;
const usualSide = 128;
const narrowestCard = 200;

class Sheet {
  constructor(host, scene) {
    this.scene = scene;
    this.factor = Math.ceil(scene.width / thumbnailSide);
    this.side = Math.ceil(scene.width / this.factor) * Math.max(1, Math.floor(usualSide / scene.width));
    this.legend = h("div");
    this.grid = h("ul", { class: "sheet" });
    this.grid.style.setProperty("--pair", `${Math.max(narrowestCard, 2 * this.side + 2)}px`);
    this.cards = [null, ...scene.rows].map((row) => this.card(row));
    this.grid.append(...this.cards.map(({ node }) => node));
    const averaged = this.factor > 1 ? `, averaged over ${this.factor} × ${this.factor} pixels` : "";
    host.append(
      h("div", { class: "sheet-head" },
        h("div", {}, h("h4", {}, "Every picture and its signed error"),
          h("p", { class: "note" }, `One colour scale for all of them${averaged}. Click for A, shift-click for B.`)),
        this.legend),
      this.grid);
    this.drawn = "";
  }

  card(row) {
    const width = Math.ceil(this.scene.width / this.factor);
    const height = Math.ceil(this.scene.height / this.factor);
    const canvas = (label) => {
      const node = h("canvas", { width, height, role: "img", "aria-label": label });
      node.style.width = `${this.side}px`;
      return node;
    };
    const name = row ? identity(row) : referenceName;
    const [image, error] = [canvas(`picture of ${row ? readable(row) : name}`), row ? canvas(`signed error of ${readable(row)}`) : null];
    const [value, badge] = [h("span", { class: "value" }), h("span", { class: "badge" })];
    const button = h("button",
      { type: "button", class: "card", "data-mode": name, click: (event) => choose(event.shiftKey ? "b" : "a", name) },
      h("span", { class: "name" }, badge, row ? [marker(row), " ", h("b", {}, row.renderer), " ", modeName(row)] : h("b", {}, "reference")),
      value,
      h("span", { class: "pair" }, image, error));
    return { row, image, error, value, badge, button, node: h("li", {}, button) };
  }

  /** Draws what has changed since; pictures are decoded one after the other, so that the page stays quick. */
  async draw() {
    const exposure = this.scene.name === state.scene ? state.exposure : 0;
    const scale = scaleOf(this.scene);
    const wanted = `${exposure} ${scale}`;
    if (this.drawn === wanted) return;
    this.drawn = wanted;
    this.legend.replaceChildren(errorLegend(scale));
    const reference = shrink(await pictureOf(this.scene, null), this.factor);
    for (const { row, image, error } of this.cards) {
      const small = row ? shrink(await pictureOf(this.scene, row), this.factor) : reference;
      if (this.drawn !== wanted) return;
      image.getContext("2d").putImageData(paintPicture(small, exposure), 0, 0);
      if (error) error.getContext("2d").putImageData(paintError(small, reference, scale), 0, 0);
    }
    this.grid.dataset.ready = "true";
  }

  mark() {
    const metric = metricOf(state.metric);
    for (const { row, button, value, badge } of this.cards) {
      const name = row ? identity(row) : referenceName;
      const chosen = ["a", "b"].filter((slot) => state[slot] === name).map((slot) => slot.toUpperCase());
      badge.textContent = chosen.join(" ");
      value.textContent = row ? figure(estimateOf(row, metric.name)[0]) : "";
      button.setAttribute("aria-pressed", String(chosen.length > 0));
    }
  }
}
