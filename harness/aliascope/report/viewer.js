// The viewer: A and B beside each other, under a slider, blinking, or as signed errors; a pixel read out.

const paneGap = 6;
const blinkPeriod = 700; // ms a picture: under three flashes a second
const isStill = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

/** What the panes of a view show: which of A and B, as a picture or its error. */
const panesOf = {
  side: [["a", "picture"], ["b", "picture"]],
  slider: [["ab", "picture"]],
  blink: [["blink", "picture"]],
  "error-a": [["a", "error"]],
  "error-b": [["b", "error"]],
  errors: [["a", "error"], ["b", "error"]],
  "samples-a": [["a", "samples"]],
  "p-values-a": [["a", "p-values"]],
};

const kindNames = { error: "signed error", samples: "samples of each pixel", "p-values": "p-values of the mean" };

class Viewer {
  constructor() {
    this.shown = "a";
    this.playing = !isStill();
    this.hovered = null;
    this.layers = new Map();
    this.loaded = null;
    this.stage = h("div", { class: "stage", tabindex: "0", role: "group", "aria-label": "Pictures; arrows walk the pixel, space blinks" });
    this.panes = [0, 1].map((index) => this.pane(index));
    this.splitter = h("input", {
      type: "range", class: "splitter", min: 0, max: 1, step: 0.005, "aria-label": "where A ends and B begins",
      input: () => change({ split: Number(this.splitter.value) }),
    });
    this.legend = h("div");
    this.stage.append(h("div", { class: "panes" }, this.panes.map(({ figure: node }) => node)));
    this.controls = new Controls(this);
    this.node = h("div", { class: "viewer" },
      h("div", { class: "stage-column" }, this.stage, this.splitter, this.legend, this.controls.readout), this.controls.node);
    new ResizeObserver(() => this.paint()).observe(this.node);
    setInterval(() => this.tick(), blinkPeriod);
    onChange((changed) => this.changed(changed));
  }

  pane(index) {
    const canvas = h("canvas", { role: "img" });
    const badge = h("span", { class: "badge" });
    const name = h("span", { class: "pane-name" });
    const pane = { canvas, badge, name, figure: h("figure", { class: "pane" }, h("figcaption", {}, badge, name), canvas) };
    const on = (type, method) => canvas.addEventListener(type, (event) => method.call(this, event, this.panes[index]));
    on("pointerdown", this.press);
    on("pointermove", this.move);
    on("pointerup", this.release);
    on("pointercancel", this.cancel);
    on("pointerleave", this.leave);
    canvas.addEventListener("wheel", (event) => this.wheel(event, this.panes[index]), { passive: false });
    return pane;
  }

  changed(changed) {
    if (changed.has("scene") || changed.has("a") || changed.has("b")) this.load();
    else if (["view", "zoom", "x", "y", "cx", "cy", "split", "exposure", "scale", "metric"].some((key) => changed.has(key))) this.paint();
  }

  async load() {
    const scene = currentScene();
    const [a, b] = [rowOf(scene, state.a), rowOf(scene, state.b)];
    const wanted = { scene, a, b };
    this.wanted = wanted;
    const [samples, surprise, reference, ...pictures] = await Promise.all(
      [samplesOf(scene, a), surpriseOf(scene, a), ...[null, a, b].map((row) => pictureOf(scene, row))]);
    if (this.wanted !== wanted) return; // another was chosen meanwhile
    this.loaded = { ...wanted, reference, samples, surprise, pictures: { a: pictures[0], b: pictures[1] } };
    this.paint();
  }

  /** A canvas of the picture's own size with its colours, kept for the next drawing. */
  layer(slot, kind) {
    const { scene, reference, pictures } = this.loaded;
    const row = this.loaded[slot];
    const scale = scaleOf(scene);
    const setting = { error: scale, picture: state.exposure, samples: "", "p-values": "" }[kind];
    const key = [scene.name, row ? identity(row) : "", kind, setting].join("\n");
    let canvas = this.layers.get(key);
    if (!canvas) {
      if (this.layers.size > 15) this.layers.delete(this.layers.keys().next().value);
      canvas = h("canvas", { width: scene.width, height: scene.height });
      const image = {
        error: () => paintError(pictures[slot], reference, scale),
        picture: () => paintPicture(pictures[slot], state.exposure),
        samples: () => paintSamples(this.loaded.samples ?? 1, scene, this.mostSamples()),
        "p-values": () => paintSurprise(this.loaded.surprise, scene),
      }[kind]();
      canvas.getContext("2d").putImageData(image, 0, 0);
      this.layers.set(key, canvas);
    }
    return canvas;
  }

  /** The end of the scale of samples: that of the scene's adaptive modes, or of a mode that takes more everywhere. */
  mostSamples() {
    const { scene, samples } = this.loaded;
    return Math.max(2, scene.mostSamples ?? 0, typeof samples === "number" ? samples : 0);
  }

  /** Sizes of the panes in CSS pixels, and the whole zoom that fits. */
  layout() {
    const { scene } = this.loaded;
    const width = this.stage.clientWidth;
    const count = panesOf[state.view].length;
    const stacked = count === 2 && width < 520;
    const most = stacked || count === 1 ? width : Math.floor((width - paneGap) / 2);
    const tallest = clamp(innerHeight * 0.72, 240, 900);
    const fit = Math.max(1, Math.floor(Math.min(most / scene.width, tallest / scene.height)));
    return {
      fit, zoom: state.zoom ?? fit, stacked,
      width: Math.min(most, scene.width * fit), height: Math.min(tallest, scene.height * fit),
    };
  }

  /** Where the picture lies in a canvas: its left top corner and the side of a pixel, in device pixels. */
  place(layout) {
    const { scene } = this.loaded;
    const ratio = devicePixelRatio;
    const zoom = Math.max(1, Math.round(layout.zoom * ratio));
    const [width, height] = [Math.round(layout.width * ratio), Math.round(layout.height * ratio)];
    const along = (size, extent, centre) =>
      extent * zoom <= size ? Math.floor((size - extent * zoom) / 2) : clamp(Math.round(size / 2 - centre * zoom), size - extent * zoom, 0);
    return {
      zoom, width, height, ratio,
      left: along(width, scene.width, state.cx ?? state.x + 0.5),
      top: along(height, scene.height, state.cy ?? state.y + 0.5),
    };
  }

  paint() {
    if (!this.loaded || this.loaded.scene !== currentScene() || !this.stage.clientWidth) return;
    const layout = this.layout();
    const place = this.place(layout);
    this.geometry = { layout, place };
    const shown = panesOf[state.view];
    this.panes.forEach((pane, i) => {
      pane.figure.hidden = i >= shown.length;
      if (i < shown.length) this.paintPane(pane, shown[i], layout, place);
    });
    this.stage.classList.toggle("stacked", layout.stacked);
    this.splitter.hidden = state.view !== "slider";
    this.splitter.value = state.split;
    this.splitter.style.width = `${layout.width}px`;
    this.legend.replaceChildren(...this.legendOf(shown[0][1]));
    this.controls.show(layout);
    this.read();
  }

  /** The scale of what a view shows, if it has one. */
  legendOf(kind) {
    if (kind === "error") return [errorLegend(scaleOf(this.loaded.scene))];
    if (kind === "samples") return [samplesLegend(this.mostSamples())];
    if (kind !== "p-values") return [];
    return [this.loaded.surprise ? surpriseLegend() : h("p", { class: "note" }, "This picture is judged by what was blessed, not pixel by pixel.")];
  }

  paintPane(pane, [slot, kind], layout, place) {
    const { canvas } = pane;
    if (canvas.width !== place.width || canvas.height !== place.height) Object.assign(canvas, { width: place.width, height: place.height });
    canvas.style.width = `${layout.width}px`;
    canvas.style.height = `${layout.height}px`;
    const pannable = this.loaded.scene.width * place.zoom > place.width || this.loaded.scene.height * place.zoom > place.height;
    canvas.style.touchAction = pannable || slot === "ab" ? "none" : "pan-y";
    const context = canvas.getContext("2d");
    context.imageSmoothingEnabled = false;
    context.clearRect(0, 0, place.width, place.height);
    const put = (layer) => context.drawImage(layer, place.left, place.top, layer.width * place.zoom, layer.height * place.zoom);
    if (slot === "ab") {
      const split = Math.round(state.split * place.width);
      this.clipped(context, 0, split, place.height, () => put(this.layer("a", kind)));
      this.clipped(context, split, place.width, place.height, () => put(this.layer("b", kind)));
      this.drawSplit(context, split, place);
    } else {
      put(this.layer(slot === "blink" ? this.shown : slot, kind));
    }
    this.drawPixel(context, place);
    this.caption(pane, slot, kind);
  }

  clipped(context, from, to, height, draw) {
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, height);
    context.clip();
    draw();
    context.restore();
  }

  drawSplit(context, split, { height, ratio }) {
    const line = Math.max(1, Math.round(ratio));
    context.fillStyle = "#000";
    context.fillRect(split - line, 0, 3 * line, height);
    context.fillStyle = "#fff";
    context.fillRect(split, 0, line, height);
  }

  /** A frame around the pixel that is read out. */
  drawPixel(context, { left, top, zoom, ratio }) {
    const [x, y] = [left + state.x * zoom, top + state.y * zoom];
    const line = Math.max(1, Math.round(ratio));
    const frame = (colour, out) => {
      context.strokeStyle = colour;
      context.lineWidth = line;
      context.strokeRect(x - (out - 0.5) * line, y - (out - 0.5) * line, zoom + (2 * out - 1) * line, zoom + (2 * out - 1) * line);
    };
    frame("#fff", 1);
    frame("#000", 2);
  }

  caption(pane, slot, kind) {
    const describe = (name) => {
      const row = this.loaded[name];
      if (!row) return ["reference"];
      return [marker(row), " ", h("b", {}, row.renderer), " ", modeName(row)];
    };
    const letter = slot === "blink" ? this.shown : slot;
    pane.badge.textContent = slot === "ab" ? "A | B" : letter.toUpperCase();
    const parts = slot === "ab" ? [describe("a"), h("span", { class: "soft" }, " | "), describe("b")] : describe(letter);
    pane.name.replaceChildren(...[kindNames[kind] ? h("span", { class: "soft" }, `${kindNames[kind]}, `) : null, parts].flat(Infinity).filter(Boolean));
    pane.canvas.setAttribute("aria-label", pane.name.textContent);
    pane.canvas.dataset.shows = `${letter} ${kind}`;
  }

  // The pixel under the pointer, else the one that was chosen.

  read() {
    const { scene, reference, pictures } = this.loaded;
    const [x, y] = this.hovered ?? [state.x, state.y];
    const i = 3 * (y * scene.width + x);
    const at = (values) => [values[i], values[i + 1], values[i + 2]];
    const { samples, surprise } = this.loaded;
    const taken = typeof samples === "number" ? samples : samples?.values[i];
    this.controls.read({ x, y, taken, surprise: surprise?.values[i], reference: at(reference.values), a: at(pictures.a.values), b: at(pictures.b.values) });
  }

  pixelAt(event, { canvas }) {
    const { place } = this.geometry;
    const box = canvas.getBoundingClientRect();
    const x = Math.floor(((event.clientX - box.left) * (canvas.width / box.width) - place.left) / place.zoom);
    const y = Math.floor(((event.clientY - box.top) * (canvas.height / box.height) - place.top) / place.zoom);
    const { width, height } = this.loaded.scene;
    return x >= 0 && y >= 0 && x < width && y < height ? [x, y] : null;
  }

  press(event, pane) {
    if (event.button !== 0 || !this.geometry) return;
    const { layout, place } = this.geometry;
    const box = pane.canvas.getBoundingClientRect();
    const pannable = this.loaded.scene.width * place.zoom > place.width || this.loaded.scene.height * place.zoom > place.height;
    const onSplit = Math.abs(event.clientX - box.left - state.split * layout.width) < 14;
    const splits = state.view === "slider" && (onSplit || !pannable);
    const centre = [(place.width / 2 - place.left) / place.zoom, (place.height / 2 - place.top) / place.zoom];
    this.drag = { x: event.clientX, y: event.clientY, centre, splits, pannable, moved: false, box };
    pane.canvas.setPointerCapture(event.pointerId);
  }

  move(event, pane) {
    if (!this.loaded || !this.geometry) return;
    const { drag } = this;
    if (drag && (drag.moved || Math.hypot(event.clientX - drag.x, event.clientY - drag.y) > 4)) {
      drag.moved = true;
      const { place } = this.geometry;
      if (drag.splits) {
        change({ split: clamp((event.clientX - drag.box.left) / drag.box.width, 0, 1) });
      } else if (drag.pannable) {
        const { width, height } = this.loaded.scene;
        const shift = (pixels) => (pixels * place.ratio) / place.zoom;
        change({ cx: clamp(drag.centre[0] - shift(event.clientX - drag.x), 0, width), cy: clamp(drag.centre[1] - shift(event.clientY - drag.y), 0, height) });
      }
      return;
    }
    if (event.pointerType !== "mouse") return;
    this.hovered = this.pixelAt(event, pane);
    this.read();
  }

  release(event, pane) {
    const { drag } = this;
    this.drag = null;
    if (!drag || drag.moved || !this.loaded) return;
    const found = this.pixelAt(event, pane);
    if (found) change({ x: found[0], y: found[1] });
  }

  cancel() {
    this.drag = null;
  }

  leave() {
    this.hovered = null;
    if (this.loaded && this.geometry) this.read();
  }

  wheel(event, pane) {
    if (!(event.ctrlKey || event.metaKey) || !this.geometry) return;
    event.preventDefault();
    this.zoomBy(event.deltaY < 0 ? 1 : -1, this.pixelAt(event, pane));
  }

  /** One step closer or further, about a pixel. */
  zoomBy(step, about = null) {
    if (!this.geometry) return;
    const { zoom } = this.geometry.layout;
    const next = clamp(step > 0 ? zoom + Math.max(1, Math.round(zoom / 3)) : zoom - Math.max(1, Math.round(zoom / 4)), 1, 64);
    const [x, y] = about ?? [state.x, state.y];
    change({ zoom: next, cx: x + 0.5, cy: y + 0.5 });
  }

  fit() {
    change({ zoom: null, cx: null, cy: null });
  }

  /** Moves the chosen pixel, and the view where the pixel would leave it. */
  walk(dx, dy) {
    if (!this.geometry) return;
    const { width, height } = this.loaded.scene;
    const [x, y] = [clamp(state.x + dx, 0, width - 1), clamp(state.y + dy, 0, height - 1)];
    this.hovered = null;
    this.look(x, y);
  }

  look(x, y) {
    const { place } = this.geometry;
    const outside = (at, origin, size) => origin + at * place.zoom < 0 || origin + (at + 1) * place.zoom > size;
    const follow = outside(x, place.left, place.width) || outside(y, place.top, place.height);
    change({ x, y, ...(follow ? { cx: x + 0.5, cy: y + 0.5 } : {}) });
    this.controls.say();
  }

  worst(slot) {
    const row = this.loaded?.[slot];
    if (row && this.geometry) this.look(...row.worst);
  }

  tick() {
    if (state.view === "blink" && this.playing && this.loaded) this.flip();
  }

  flip() {
    this.shown = this.shown === "a" ? "b" : "a";
    this.paint();
  }

  /** Space: into the blink view, and there from one picture to the other by hand. */
  blink() {
    if (state.view !== "blink") {
      change({ view: "blink" });
      return;
    }
    this.playing = false;
    this.flip();
  }

  /** The samples of A, and back. */
  toggleSamples() {
    if (withSamples) change({ view: state.view === "samples-a" ? "side" : "samples-a" });
  }

  /** The p-values of A, and back. */
  togglePValues() {
    if (withTests) change({ view: state.view === "p-values-a" ? "side" : "p-values-a" });
  }

  nextError() {
    change({ view: { "error-a": "error-b", "error-b": "errors", errors: "side" }[state.view] ?? "error-a" });
  }

  /** A becomes the reference, or again what it was. */
  toggleReference() {
    if (state.a !== referenceName) {
      this.before = state.a;
      choose("a", referenceName);
    } else {
      const scene = currentScene();
      const known_ = this.before !== undefined && rowOf(scene, this.before) !== undefined;
      choose("a", known_ ? this.before : defaultPair(scene)[0]);
    }
  }
}
