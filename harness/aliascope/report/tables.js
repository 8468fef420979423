// The tables of modes: sorted by a click on their heads, the best of a column in bold and what cannot be told from it, A and B chosen in their rows.

const columns = [
  { key: "mode", title: () => "Mode" },
  { key: "error", title: (metric) => metric.label, unit: (metric) => metric.unit, number: true, spread: true },
  { key: "spp", title: () => "Samples", unit: () => "a pixel", number: true },
  { key: "cpu", title: () => "CPU time", unit: () => "s", number: true, spread: true },
  { key: "efficiency", title: () => "Efficiency", unit: (metric, power) => `${unitText(power)}/(MSE·s)`, number: true, spread: true },
  { key: "pictures", title: () => "Pictures", number: true },
];

/** The power of a thousand that the efficiencies of a table are given in, so that its figures stay short. */
function efficiencyPower(rows) {
  const values = rows.map((row) => efficiencyOf(row)[0]).filter((value) => value !== null).sort((a, b) => a - b);
  return values.length ? clamp(3 * Math.floor(Math.log10(values[values.length >> 1]) / 3), 0, 15) : 0;
}

const unitText = (power) => (power === 0 ? "1" : `10${superscript(power)}`);

/** What a column sorts by, where less comes first going up; null goes last either way. */
function sortValue(row, key, metric) {
  switch (key) {
    case "mode": return readable(row);
    case "error": return badnessOf(row, metric);
    case "spp": return row.spp;
    case "cpu": return row.cpu[0];
    case "efficiency": return efficiencyOf(row)[0];
    default: return row.pictures;
  }
}

function sortedRows(rows, sort, metric) {
  const [key, direction] = sort.split("-");
  const sign = direction === "up" ? 1 : -1;
  const order = new Intl.Collator("en", { numeric: true });
  return rows
    .map((row, index) => ({ row, index, value: sortValue(row, key, metric) }))
    .sort((a, b) => {
      if (a.value === null || b.value === null) return Number(a.value === null) - Number(b.value === null) || a.index - b.index;
      const less = key === "mode" ? order.compare(a.value, b.value) : a.value === b.value ? 0 : a.value < b.value ? -1 : 1;
      return sign * less || a.index - b.index;
    })
    .map(({ row }) => row);
}

/** The standard error of what a column sorts by. */
function sortError(row, key, metric) {
  switch (key) {
    case "error": return estimateOf(row, metric.name)[1];
    case "cpu": return row.cpu[1];
    case "efficiency": return efficiencyOf(row)[1];
    default: return null;
  }
}

/** The rows that are best in a column, and those that cannot be told from it; none where all are alike. A time too
 *  short to be told is no figure. */
function bestOf(given, key, metric) {
  const sign = key === "efficiency" ? -1 : 1;
  const found = given
    .filter((row) => key !== "cpu" || row.cpu[0] > 0)
    .map((row) => ({ row, figure: [sortValue(row, key, metric), sortError(row, key, metric)] }))
    .filter(({ figure }) => figure[0] !== null);
  if (new Set(found.map(({ figure }) => figure[0])).size < 2) return new Set();
  const best = found.reduce((a, b) => (sign * b.figure[0] < sign * a.figure[0] ? b : a)).figure;
  return new Set(found.filter(({ figure }) => figure[0] === best[0] || alike(figure, best)).map(({ row }) => row));
}

class ModeTable {
  /** `picks` is whether rows can be put into A and B: those of a scene, not the pooled ones. */
  constructor(host, rows, caption, picks) {
    Object.assign(this, { rows, caption, picks });
    this.scene = documentData.scenes.find((scene) => scene.rows === rows);
    this.table = h("table", { class: "modes", click: (event) => this.click(event) });
    host.append(
      h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption }, this.table),
      h("p", { class: "note" }, "Bold: the best of a column, and what its uncertainty does not tell from it."));
    this.draw();
  }

  draw() {
    const metric = metricOf(state.metric);
    this.power = efficiencyPower(this.rows);
    this.sorted = sortedRows(this.rows, state.sort, metric);
    const best = Object.fromEntries(["error", "cpu", "efficiency"].map((key) => [key, bestOf(this.rows, key, metric)]));
    const cells = this.figures(metric);
    const body = this.sorted.map((row, i) => this.row(row, i, cells, best));
    this.table.replaceChildren(h("caption", { class: "hidden" }, this.caption), this.head(metric), h("tbody", {}, body));
  }

  /** The texts of the number columns, points in line down each. */
  figures(metric) {
    const pairs = {
      error: this.sorted.map((row) => (badnessOf(row, metric) === -Infinity ? [null, null] : estimateOf(row, metric.name))),
      cpu: this.sorted.map((row) => (row.cpu[0] === 0 ? [0, null] : row.cpu)),
      efficiency: this.sorted.map((row) => efficiencyOf(row).map((value) => (value === null ? null : value / 10 ** this.power))),
    };
    const columns_ = {};
    for (const [key, list] of Object.entries(pairs)) {
      columns_[key] = alignPoints(list.map(([value, error]) => (key === "cpu" ? timeFigure(value) : estimated(value, error))));
      columns_[`${key}±`] = alignPoints(list.map(([value, error]) => (value === null ? "" : uncertainty(value, error))));
    }
    const known = this.picks ? tradeOf(this.scene)?.efficiency ?? {} : {};
    columns_["efficiency±"] = this.sorted.map((row, i) => {
      const ends = known[identity(row)];
      return ends ? rangeText(...ends.slice(1).map((end) => (end === null ? null : end / 10 ** this.power))).replace(" to ", "\u2013") : columns_["efficiency±"][i];
    });
    columns_.error = columns_.error.map((text, i) => (badnessOf(this.sorted[i], metric) === -Infinity ? "∞" : text));
    columns_.spp = alignPoints(this.sorted.map((row) => (Number.isInteger(row.spp) ? groups(String(row.spp)) : figure(row.spp))));
    columns_.pictures = this.sorted.map((row) => String(row.pictures));
    return columns_;
  }

  head(metric) {
    const [sortKey, direction] = state.sort.split("-");
    const cells = columns.map(({ key, title, unit, number, spread }) => {
      const active = key === sortKey;
      return h("th",
        {
          scope: "col", class: number ? "number" : null, colspan: spread ? 2 : null,
          "aria-sort": active ? (direction === "up" ? "ascending" : "descending") : "none",
        },
        h("button", { type: "button", "data-sort": key },
          title(metric), h("span", { class: "arrow", "aria-hidden": "true" }, active ? (direction === "up" ? "▲" : "▼") : ""),
          unit?.(metric, this.power) ? [h("br"), h("span", { class: "unit" }, unit(metric, this.power))] : null));
    });
    if (this.picks) cells.push(h("th", { scope: "col", class: "slots" }, "View as"));
    return h("thead", {}, h("tr", {}, cells));
  }

  row(row, i, cells, best) {
    const number = (key, bold) => h("td", { class: bold ? "number best" : "number" }, cells[key][i]);
    const remarks = [
      row.notFinite ? h("span", { class: "bad" }, ` ${counted(row.notFinite, "pixel")} not finite`) : null,
      row.missing.length ? h("span", { class: "soft" }, ` lacks ${row.missing.join("; ")}`) : null,
    ];
    const slots = ["a", "b"].map((slot) =>
      h("button", {
        type: "button", class: `slot ${slot}`, "data-slot": slot, "aria-pressed": String(state[slot] === identity(row)),
        "aria-label": `show ${readable(row)} as ${slot.toUpperCase()}`,
      }, slot.toUpperCase()));
    return h("tr", { "data-mode": identity(row), class: this.picks ? "picks" : null },
      h("th", { scope: "row" }, marker(row), " ", h("span", { class: "renderer" }, row.renderer), " ", modeName(row), remarks),
      number("error", best.error.has(row)),
      h("td", { class: "spread" }, cells["error±"][i]),
      number("spp"),
      number("cpu", best.cpu.has(row)),
      h("td", { class: "spread" }, cells["cpu±"][i]),
      number("efficiency", best.efficiency.has(row)),
      h("td", { class: "spread" }, cells["efficiency±"][i]),
      number("pictures"),
      this.picks ? h("td", { class: "slots" }, slots) : null);
  }

  click(event) {
    const head = event.target.closest("[data-sort]");
    if (head) {
      const [key, direction] = state.sort.split("-");
      const pressed = head.dataset.sort;
      const first = pressed === "efficiency" ? "down" : "up";
      const turned = direction === "up" ? "down" : "up";
      change({ sort: `${pressed}-${pressed === key ? turned : first}` });
      this.table.querySelector(`[data-sort="${pressed}"]`).focus();
      return;
    }
    const row = event.target.closest("tbody tr");
    if (!row || !this.picks) return;
    const slot = event.target.closest("[data-slot]")?.dataset.slot ?? (event.shiftKey ? "b" : "a");
    choose(slot, row.dataset.mode);
  }

  mark() {
    for (const button of this.table.querySelectorAll("[data-slot]")) {
      const name = button.closest("tr").dataset.mode;
      button.setAttribute("aria-pressed", String(state[button.dataset.slot] === name));
    }
  }
}

/** What a scene has no figures of, and why. */
function lackingList(scene) {
  if (!scene.lacking.length) return null;
  const items = scene.lacking.map(({ kind, renderer, reason, modes }) =>
    h("li", { class: kind === "failed" ? "bad-rule" : null },
      h("b", {}, renderer), kind === "failed" ? " failed" : " cannot draw it", `: ${reason}`,
      h("span", { class: "soft" }, " ", modes.length > 3 ? counted(modes.length, "mode") : modes.map((mode, i) => [i ? ", " : "", spec(mode)]))));
  return h("div", { class: "lacking" }, h("h4", {}, "Empty cells"), h("ul", {}, items));
}
