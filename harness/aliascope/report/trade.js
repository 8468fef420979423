// What a unit of time buys, as tables: the time to an error, the error after a time, rates, ratios over scenes, knobs.

const tabNames = { error: "To reach an error", time: "In a given time", rate: "Convergence", scenes: "Over all scenes", knobs: "Knobs" };
const howNames = { measured: "measured", between: "between two modes", extrapolated: "extrapolated" };

/** The tabs that there is something for. */
function tabsOfTrade() {
  const some = (key) => Object.values(trade.scenes).some((scene) => scene[key].length);
  const has = { error: some("reach"), time: some("afford"), rate: some("convergence"), scenes: trade.ratios.length > 0 && Object.keys(trade.scenes).length > 1, knobs: trade.knobs.length > 0 };
  return tradeTabs.filter((tab) => has[tab]);
}

/** A head of cells; what is not the first is a number, but for those in `texts`. */
const headRow = (titles, texts = []) =>
  h("thead", {}, h("tr", {}, titles.map((title, i) => h("th", { scope: "col", class: i && !texts.includes(title) ? "number" : null }, title))));

const familyCell = (renderer, family) =>
  h("th", { scope: "row" }, marker({ renderer, family }), " ", h("span", { class: "renderer" }, renderer), " ", familyName(renderer, family));

const numberCell = (text, best = false) => h("td", { class: best ? "number best" : "number" }, text);

/** "4.41 to 10.1" in a cell of its own. */
const rangeCell = (figures) => h("td", { class: "range number" }, figures ? rangeText(figures[1], figures[2]) : "");

/** A scale of ratios, equal steps for equal factors, 1 in the middle: time as a disc, error as a square, with intervals. */
function ratioPicture(marks, widest) {
  const [width, height] = [132, 10 * marks.length + 6];
  const limit = Math.log(widest);
  const x = (ratio) => clamp(width / 2 + (Math.log(ratio) / limit) * (width / 2 - 5), 1, width - 1);
  const rows = marks.map(([value, low, high], i) => {
    const y = 8 + 10 * i;
    return s("g", {},
      low > 0 && high > 0 ? s("line", { class: "spread", x1: x(low), x2: x(high), y1: y, y2: y }) : "",
      i === 0 ? s("circle", { cx: x(value), cy: y, r: 3 }) : s("rect", { x: x(value) - 2.8, y: y - 2.8, width: 5.6, height: 5.6 }));
  });
  return s("svg", { class: "ratio", viewBox: `0 0 ${width} ${height}`, width, height, "aria-hidden": "true" },
    s("line", { class: "one", x1: width / 2, x2: width / 2, y1: 0, y2: height }), rows);
}

/** The ends of the scale for all ratios of a table: no ratio nearer to 1 than 2 takes all of it. */
function widestOf(marks) {
  const factors = marks.filter(Boolean).map(([value]) => Math.max(value, 1 / value));
  return Math.min(1000, 1.25 * Math.max(2, ...factors));
}

class TradeTables {
  constructor(host) {
    this.tabs = tabsOfTrade();
    this.buttons = this.tabs.map((tab) => h("button",
      { type: "button", role: "tab", id: `trade-tab-${tab}`, "aria-controls": `trade-panel-${tab}`, click: () => change({ trade: tab }) }, tabNames[tab]));
    this.panels = this.tabs.map((tab) =>
      h("div", { role: "tabpanel", id: `trade-panel-${tab}`, class: "trade-panel", "aria-labelledby": `trade-tab-${tab}` }));
    const list = h("div", { class: "tabs", role: "tablist", "aria-label": "Tables of the trade" }, this.buttons);
    list.addEventListener("keydown", (event) => this.key(event));
    host.append(list, ...this.panels);
    onChange((changed) => ["trade", "scene", "reach", "afford"].some((key) => changed.has(key)) && this.draw());
    this.draw();
  }

  current() {
    return this.tabs.includes(state.trade) ? state.trade : this.tabs[0];
  }

  key(event) {
    const now = this.tabs.indexOf(this.current());
    const next = { ArrowRight: now + 1, ArrowLeft: now - 1, Home: 0, End: this.tabs.length - 1 }[event.key];
    if (next === undefined) return;
    const index = (next + this.tabs.length) % this.tabs.length;
    change({ trade: this.tabs[index] });
    this.buttons[index].focus();
    event.preventDefault();
    event.stopPropagation();
  }

  /** All of them: those that are not in sight are printed too. */
  draw() {
    const current = this.current();
    this.tabs.forEach((tab, i) => {
      this.buttons[i].setAttribute("aria-selected", String(tab === current));
      this.buttons[i].setAttribute("tabindex", tab === current ? "0" : "-1");
      const panel = this.panels[i];
      panel.hidden = tab !== current;
      const focused = panel.contains(document.activeElement) ? document.activeElement.dataset.keep : undefined;
      panel.replaceChildren(h("h4", { class: "print-title" }, tabNames[tab]), ...this.contents(tab).flat(Infinity).filter(Boolean));
      if (focused !== undefined) panel.querySelector(`[data-keep="${CSS.escape(focused)}"]`)?.focus();
    });
  }

  contents(tab) {
    switch (tab) {
      case "error": return this.reach();
      case "time": return this.afford();
      case "rate": return this.rates();
      case "scenes": return this.ratios();
      default: return knobTable();
    }
  }

  sceneChooser() {
    const names = documentData.scenes.map(({ name }) => name).filter((name) => trade.scenes[name]);
    if (names.length < 2) return null;
    const select = h("select", { "data-keep": "scene", change: () => chooseScene(select.value) }, names.map((name) => h("option", { value: name }, name)));
    select.value = state.scene;
    return h("label", { class: "field" }, "Of ", select);
  }

  /** Radio buttons for a few targets: [value, text]; the one nearest to what is asked is chosen. */
  targets(key, list, chosen, title) {
    const radios = list.map(([value, text]) => h("label", {},
      h("input", { type: "radio", name: `trade-${key}`, value: String(value), "data-keep": `${key}-${value}`, checked: value === chosen, change: () => change({ [key]: value }) }),
      h("span", {}, text)));
    return h("fieldset", { class: "views targets" }, h("legend", { class: "field" }, title), radios);
  }

  nearest(list, asked) {
    const values = list.map(([value]) => value);
    if (asked === null || !(asked > 0)) return values[(values.length - 1) >> 1];
    const away = (value) => Math.abs(Math.log(value / asked));
    return values.reduce((a, b) => (away(b) < away(a) ? b : a));
  }

  nothingHere() {
    return [h("div", { class: "trade-head" }, this.sceneChooser()), h("p", { class: "note" }, `Too little was measured of ${state.scene} for this table.`)];
  }

  reach() {
    const own = tradeOf(currentScene());
    if (!own?.reach.length) return this.nothingHere();
    const list = own.reach.map(([error]) => [error, figure(error, 1)]);
    if (own.quantisation.length) list.push([trade.quantisation, `8 bits: ${figure(trade.quantisation)}`]);
    list.sort((a, b) => b[0] - a[0]);
    const chosen = this.nearest(list, state.reach);
    const rows = chosen === trade.quantisation ? own.quantisation : own.reach.find(([error]) => error === chosen)[1];
    const cannot = (best) => `cannot: its best is ${figure(best)}`;
    return [
      h("div", { class: "trade-head" }, this.sceneChooser(), this.targets("reach", list, chosen, "RMSE of at most")),
      this.answers(`CPU seconds to reach RMSE ${figure(chosen)} on ${state.scene}`, "CPU s", rows, cannot),
      chosen === trade.quantisation ? h("p", { class: "note" }, "The error of rounding to 8 bits, 1/255/√12: what is below it a picture of 8 bits does not show.") : null,
    ];
  }

  afford() {
    const own = tradeOf(currentScene());
    if (!own?.afford.length) return this.nothingHere();
    const list = own.afford.map(([seconds]) => [seconds, `${figure(seconds, 1)} s`]);
    const chosen = this.nearest(list, state.afford);
    const rows = own.afford.find(([seconds]) => seconds === chosen)[1];
    const cannot = (fastest) => `cannot: its fastest takes ${figure(fastest)}\u00a0s`;
    return [
      h("div", { class: "trade-head" }, this.sceneChooser(), this.targets("afford", list, chosen, "CPU time of at most")),
      this.answers(`RMSE on ${state.scene} after ${figure(chosen)} CPU seconds`, "RMSE", rows, cannot),
    ];
  }

  /** Families by their figure, the best first, and what its interval does not tell from it in bold; then those that
   *  cannot, by how near they come. */
  answers(caption, title, rows, cannot) {
    const sorted = [...rows].sort((a, b) => (a[2] && b[2] ? a[2][0] - b[2][0] : Number(!a[2]) - Number(!b[2]) || a[6] - b[6]));
    const best = sorted[0]?.[2];
    const texts = alignPoints(sorted.map(([, , figures]) => (figures ? figure(figures[0]) : "–")));
    const body = sorted.map(([renderer, family, figures, how, mode, label, limit], i) => {
      const open = h("button", {
        type: "button", class: "link", "data-keep": `${renderer} ${mode}`,
        "aria-label": `${renderer} ${label}: show it beside the reference`,
        click: () => choose("a", `${renderer} ${mode}`, { b: referenceName }) && showPictures(),
      }, modeName({ label, mode }));
      const told = figures && (figures[0] === best[0] || (figures[1] !== null && best[2] !== null && figures[1] <= best[2]));
      return h("tr", { class: [figures ? "" : "none", how === "extrapolated" ? "far" : ""].join(" ").trim() || null },
        familyCell(renderer, family), numberCell(texts[i], told), rangeCell(figures),
        h("td", { class: how === "extrapolated" ? "extrapolated" : null }, figures ? howNames[how] : cannot(limit)), h("td", {}, open));
    });
    return [
      scrolled(caption, h("table", { class: "plain trade" }, h("caption", { class: "hidden" }, caption),
        headRow(["Family", title, "95 % interval", "How", "Mode to choose"], ["How", "Mode to choose"]), h("tbody", {}, body))),
      h("p", { class: "note" }, "Bold: the best, and what its interval does not tell from it. Between two modes, and beyond the last one, a family's figure is no mode's own: the mode to choose is a measured one."),
    ];
  }

  rates() {
    const own = tradeOf(currentScene());
    if (!own?.convergence.length) return this.nothingHere();
    const sorted = [...own.convergence].sort((a, b) => a[2][0] - b[2][0]);
    const cell = (figures) => [numberCell(figures ? minus(figures[0].toFixed(2)) : "–"), h("td", { class: "range number" }, figures ? exponents(figures) : "")];
    const body = sorted.map(([renderer, family, samples, time, curved, modes]) =>
      h("tr", {}, familyCell(renderer, family), cell(samples), cell(time), numberCell(String(modes)), h("td", {}, curved ? "not a power: curved" : "")));
    const caption = `How fast the error falls on ${state.scene}`;
    return [
      h("div", { class: "trade-head" }, this.sceneChooser()),
      scrolled(caption, h("table", { class: "plain trade" }, h("caption", { class: "hidden" }, caption),
        headRow(["Family", "samples^", "95 % interval", "CPU seconds^", "95 % interval", "Modes", "Remark"], ["Remark"]), h("tbody", {}, body))),
      h("p", { class: "note" }, "RMSE falls as samples, or as CPU seconds, to this power. Plain Monte Carlo has \u22120.50; a picture of edges, with even samples, \u22120.75."),
    ];
  }

  ratios() {
    const known = ([, , time, error]) => (time ?? error ?? [Infinity])[0];
    const sorted = [...trade.ratios].sort((a, b) => known(a) - known(b));
    const widest = widestOf(sorted.flatMap(([, , time, error]) => [time, error]));
    const most = Math.max(...sorted.map((row) => row[4].length));
    const cells = (figures) => [numberCell(figures ? figure(figures[0]) : "–"), rangeCell(figures)];
    const body = sorted.map(([renderer, family, time, error, scenes]) => {
      const isBase = trade.base && renderer === trade.base[0] && family === trade.base[1];
      return h("tr", { class: isBase ? "base" : null }, familyCell(renderer, family), cells(time), cells(error),
        h("td", {}, time && error ? ratioPicture([time, error], widest) : ""),
        h("td", { class: "number", title: scenes.join(", ") }, scenes.length < most ? `${scenes.length} of ${most}` : String(scenes.length)));
    });
    const caption = "Times at equal error and errors at equal time, over all scenes";
    return [
      h("p", {}, "Ratios to ", h("b", {}, trade.base.join(" ").replace(`${trade.base[0]} ${trade.base[0]} `, `${trade.base[0]} `)),
        ", scene by scene, and their geometric mean: below 1 is better than it."),
      scrolled(caption, h("table", { class: "plain trade" }, h("caption", { class: "hidden" }, caption),
        headRow(["Family", "Time at equal error ●", "95 % interval", "Error at equal time ■", "95 % interval", "", "Scenes"].map((text) => text || h("span", { class: "hidden" }, "picture")), [""]),
        h("tbody", {}, body))),
    ];
  }
}

const exponents = ([, low, high]) => (low === null || high === null ? "" : `${minus(low.toFixed(2))} to ${minus(high.toFixed(2))}`);

/** A table in a box of its own, which scrolls sideways where it is too wide. */
const scrolled = (label, table) => h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": label }, table);
