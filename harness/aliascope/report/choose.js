// "Which one?": the best mode for a time or an error, from the Pareto front; what the plot shows; the legend.

function metricChooser() {
  const options = metricNames.map((name) => h("option", { value: name }, metricOf(name).title));
  // An error asked for is one of the metric that it was asked in.
  const pick = (name) => change({ metric: name, ...(state.error === null ? {} : { error: Number(usualError(metricOf(name))) }) });
  const select = h("select", { id: "metric", change: () => pick(select.value) }, options);
  const show = () => (select.value = state.metric);
  onChange((changed) => changed.has("metric") && show());
  show();
  return h("label", { class: "field" }, "Error as ", select);
}

/** What the first plot is of, and against what. */
function plotChoosers(plot, heading) {
  const scenes = documentData.scenes.filter(({ rows }) => rows.length);
  const over = h("select",
    { "aria-label": "scenes of the plot", change: () => (over.value === "all" ? change({ over: "all" }) : (chooseScene(over.value.slice(1)), change({ over: "scene" }))) },
    h("option", { value: "all" }, scopeName), scenes.map(({ name }) => h("option", { value: `=${name}` }, name)));
  const cost = h("select", { change: () => change({ cost: cost.value }) }, costNames.map((name) => h("option", { value: name }, costs[name].name)));
  const show = () => {
    const own = state.over === "scene" && documentData.scenes.length > 1;
    over.value = own ? `=${state.scene}` : "all";
    cost.value = state.cost;
    heading.textContent = `Error against ${costs[state.cost].against}, ${own ? state.scene : scopeName}`;
  };
  onChange((changed) => {
    if (!["over", "scene", "cost"].some((key) => changed.has(key))) return;
    show();
    if (plot.rows !== scopeRows()) plot.show(scopeRows());
  });
  show();
  return h("div", { class: "fields" },
    documentData.scenes.length > 1 ? h("label", { class: "field" }, "Of ", over) : null,
    metricChooser(),
    costNames.length > 1 ? h("label", { class: "field" }, "Cost as ", cost) : null);
}

/** "all 7 scenes", or of how many. */
const scopeName = (() => {
  const [pooled, all] = [documentData.pooledScenes.length, documentData.countedScenes.length];
  if (all === 1) return `the scene ${documentData.countedScenes[0]}`;
  if (pooled === all && all === 2) return "both scenes";
  return pooled === all ? `all ${all} scenes` : `${pooled} of ${all} scenes`;
})();

/** The rows that are asked about, and what they are called. */
function scopeRows() {
  const scene = currentScene();
  return state.over === "scene" && documentData.scenes.length > 1 ? scene.rows : documentData.pooled;
}

/** A time between the fastest and the slowest mode of the front, of one significant digit. */
function usualTime(rows, metric) {
  const front = paretoFront(rows, metric);
  if (!front.length) return 1;
  return Number(Math.sqrt(front[0].time * front[front.length - 1].time).toPrecision(1));
}

/** The best row for what is asked: {row}, or {reason} where there is none. `rows` are one renderer's or all. */
function answer(rows, metric, asked) {
  const front = paretoFront(rows, metric);
  if (!front.length && rows.some((row) => row.cpu[0] === 0)) return { reason: "too short a time" };
  if (!front.length) return { reason: rows.some((row) => row.missing.length) ? "lacks scenes" : "has no figures" };
  if (asked.time !== null) {
    const within = front.filter(({ time }) => time <= asked.time);
    return within.length ? { row: within[within.length - 1].row } : { reason: `fastest takes ${figure(front[0].time)}\u00a0s` };
  }
  const limit = metric.badness(asked.error);
  const found = front.find(({ badness }) => badness <= limit);
  const best = front[front.length - 1].row;
  return found ? { row: found.row } : { reason: `best is ${figure(estimateOf(best, metric.name)[0])}` };
}

/** What a time reaches, or the usual one, to two digits: a start for the question of the error. */
function usualError(metric, time = null) {
  const rows = scopeRows();
  const { row } = answer(rows, metric, { time: time ?? usualTime(rows, metric), error: null });
  const value = row ? estimateOf(row, metric.name)[0] : null;
  return value === null ? "0.01" : String(Number(value.toPrecision(2)));
}

class Chooser {
  constructor(host) {
    this.time = this.input("time", "any positive time in seconds");
    this.error = this.input("error", "an error in the metric chosen");
    this.timeRadio = h("input", { type: "radio", name: "ask", value: "time", change: () => this.turn("time") });
    this.errorRadio = h("input", { type: "radio", name: "ask", value: "error", change: () => this.turn("error") });
    this.errorName = h("span");
    this.over = h("select", { "aria-label": "scenes", change: () => change({ over: this.over.value }) });
    this.result = h("div", { class: "answer", "aria-live": "polite" });
    host.append(
      h("h3", {}, "Which one?"),
      h("div", { class: "questions" },
        h("label", {}, this.timeRadio, h("span", {}, "I have"), this.time, h("span", {}, "CPU s a picture")),
        h("label", {}, this.errorRadio, h("span", {}, "I need"), this.errorName, this.error),
        h("label", { class: "over" }, h("span", {}, "over"), this.over)),
      this.result,
    );
    onChange((changed) => {
      if (["time", "error", "metric", "over", "scene"].some((key) => changed.has(key))) this.show();
    });
    this.show();
  }

  input(key, title) {
    const node = h("input", { type: "text", inputmode: "decimal", size: 7, title, "aria-label": title, autocomplete: "off" });
    node.addEventListener("input", () => this.ask(key));
    return node;
  }

  /** What a field says, null where that makes no sense. */
  said(key) {
    const text = this[key].value.trim().replace(",", ".").replace("\u2212", "-");
    const value = text === "" ? NaN : Number(text);
    return Number.isFinite(value) && (key !== "time" || value > 0) ? value : null;
  }

  ask(key) {
    const value = this.said(key);
    this[key].setAttribute("aria-invalid", String(value === null));
    if (value !== null) change(key === "time" ? { time: value, error: null } : { time: null, error: value });
  }

  turn(key) {
    this.ask(key);
    this.show(); // where the field makes no sense, the question stays
  }

  /** Puts a value into a field that does not say it; "0.10" may stay while it is typed. */
  write(key, value) {
    if (this.said(key) !== value) this[key].value = String(value);
    this[key].setAttribute("aria-invalid", "false");
  }

  show() {
    const metric = metricOf(state.metric);
    const rows = scopeRows();
    const byError = state.error !== null;
    const asked = { time: byError ? null : state.time ?? usualTime(rows, metric), error: state.error };
    this.timeRadio.checked = !byError;
    this.errorRadio.checked = byError;
    this.errorName.textContent = `${metric.label} ${metric.more ? "≥" : "≤"}`;
    if (byError) this.write("error", asked.error);
    else this.write("time", asked.time);
    if (!byError && document.activeElement !== this.error) this.error.value = usualError(metric, asked.time);
    this.over.replaceChildren(
      h("option", { value: "all" }, scopeName),
      ...(documentData.scenes.length === 1 ? [] : [h("option", { value: "scene" }, state.scene)]));
    this.over.value = documentData.scenes.length === 1 ? "all" : state.over;
    this.result.replaceChildren(...this.table(rows, metric, asked).filter(Boolean));
  }

  /** What a row is judged by where something is asked: the error of those that have the time, else the time. */
  judged(row, metric, asked) {
    return asked.time === null ? row.cpu : [badnessOf(row, metric), estimateOf(row, metric.name)[1]];
  }

  table(rows, metric, asked) {
    const overall = answer(rows, metric, asked).row;
    const body = documentData.renderers.map((renderer) => {
      const { row, reason } = answer(rows.filter((each) => each.renderer === renderer), metric, asked);
      const best = row !== undefined && (row === overall || alike(this.judged(row, metric, asked), this.judged(overall, metric, asked)));
      return { renderer, row, reason, best };
    });
    body.sort((a, b) => Number(b.best) - Number(a.best));
    const head = ["", metric.title, "CPU s"].map((text, i) =>
      h("th", { scope: "col", class: i ? "number" : null }, text || h("span", { class: "hidden" }, "renderer and mode")));
    return [
      h("table", { class: "plain" },
        h("caption", { class: "hidden" }, "The best mode of each renderer for this"),
        h("thead", {}, h("tr", {}, head)),
        h("tbody", {}, body.map((entry) => this.line(entry, metric)))),
      this.remarks(rows, metric, asked, overall),
    ];
  }

  /** How sure the answer is: what cannot be told from it, and how probable it is that nothing beats it. */
  remarks(rows, metric, asked, overall) {
    if (!overall) return null;
    const limit = asked.time === null ? metric.badness(asked.error) : null;
    const fits = (row) => (limit === null ? row.cpu[0] <= asked.time : badnessOf(row, metric) !== null && badnessOf(row, metric) <= limit);
    const others = rows
      .filter((row) => row !== overall && !row.missing.length && row.cpu[0] > 0 && badnessOf(row, metric) !== null && fits(row))
      .filter((row) => alike(this.judged(row, metric, asked), this.judged(overall, metric, asked)));
    others.sort((a, b) => this.judged(a, metric, asked)[0] - this.judged(b, metric, asked)[0]);
    const chance = metric.name === "rmse" ? chanceOf(rows, overall) : null;
    const told = others.slice(0, 3).map((row, i) => [i ? "; " : "", row.renderer, " ", modeName(row)]);
    return h("p", { class: "note sure" },
      others.length ? ["Cannot be told from it: ", told, others.length > 3 ? `; and ${others.length - 3} more. ` : ". "] : "No other mode is as good within its uncertainty. ",
      chance === null ? null : `Probability of being on the front: ${percent(chance)}.`);
  }

  line({ renderer, row, reason, best }, metric) {
    const name = h("th", { scope: "row" },
      h("span", { class: "whole" }, h("span", { class: "dot", "aria-hidden": "true" }), renderer), row ? [h("br"), modeName(row)] : null);
    name.querySelector(".dot").style.backgroundColor = colourOf(renderer);
    if (!row) return h("tr", { class: "none" }, name, h("td", { colspan: 2, class: "number" }, reason));
    const [value, error] = estimateOf(row, metric.name);
    const ends = endsOf(row.cpu);
    const cell = (text, spread) => h("td", { class: "number" }, text, spread ? h("small", {}, spread) : null);
    return h("tr", { class: best ? "best" : null }, name,
      cell(figure(value), value === null ? "" : uncertainty(value, error).replace(" ", "\u00a0")),
      cell(figure(row.cpu[0]), ends ? rangeText(...ends) : ""));
  }
}

/** Renderers and families; a family is brought forward under the pointer and hidden or shown by a click, a renderer
 *  with all of its families. Those that the plot does not show are left out. */
function legend(host, plots) {
  host.append(h("h3", {}, "Legend"));
  for (const renderer of documentData.renderers) {
    const families = documentData.families.filter(([name]) => name === renderer);
    if (!families.length) continue;
    const items = families.map((entry) => {
      const family = entry[1];
      const key = `${renderer}\n${family}`;
      const index = String(documentData.families.indexOf(entry));
      const emphasise = (on) => plots.forEach((plot) => plot.emphasise(on ? key : null));
      const toggle = h("button",
        {
          type: "button", "aria-pressed": "true", title: "hide or show",
          pointerenter: () => emphasise(true), pointerleave: () => emphasise(false),
          focus: () => emphasise(true), blur: () => emphasise(false),
          click: () => change({ hidden: withName(state.hidden, index, toggle.getAttribute("aria-pressed") === "true") }),
        },
        marker({ renderer, family }), " ", familyName(renderer, family));
      const show = () => {
        const hidden = (state.hidden ?? "").split(",").includes(index);
        toggle.setAttribute("aria-pressed", String(!hidden));
        for (const plot of plots) {
          plot.hidden[hidden ? "add" : "delete"](key);
          plot.applyHidden();
        }
      };
      onChange((changed) => changed.has("hidden") && show());
      show();
      return h("li", { "data-family": key }, toggle);
    });
    const whole = rendererToggle(renderer, families.map((entry) => String(documentData.families.indexOf(entry))));
    const block = h("div", { class: "renderer" }, h("h4", {}, whole), h("ul", {}, items));
    const leaveOut = () => {
      const shown = new Set(scopeRows().map((row) => `${row.renderer}\n${row.family}`));
      for (const item of items) item.hidden = !shown.has(item.dataset.family);
      block.hidden = items.every((item) => item.hidden);
    };
    onChange((changed) => (changed.has("over") || changed.has("scene")) && leaveOut());
    leaveOut();
    host.append(block);
  }
  host.append(h("p", { class: "keyline" }, h("span", { class: "front-sample", "aria-hidden": "true" }),
    "Pareto front: nothing is both cheaper and better"),
  h("p", { class: "keyline" }, s("svg", { viewBox: "-9 -9 18 18", width: 18, height: 18, "aria-hidden": "true" }, s("circle", { class: "chance", r: 7.5 })),
    "Ring, the stronger the more probable: on the front"));
}

/** Hides or shows all families of a renderer. */
function rendererToggle(renderer, indices) {
  const hidden = () => indices.every((index) => (state.hidden ?? "").split(",").includes(index));
  const turn = (hide) => change({ hidden: indices.reduce((text, index) => withName(text, index, hide), state.hidden) });
  const button = h("button", { type: "button", class: "whole", title: "hide or show all of it", click: () => turn(!hidden()) },
    h("span", { class: "dot", "aria-hidden": "true" }), renderer);
  button.querySelector(".dot").style.backgroundColor = colourOf(renderer);
  const show = () => button.setAttribute("aria-pressed", String(!hidden()));
  onChange((changed) => changed.has("hidden") && show());
  show();
  return button;
}
