// The knobs: what each setting does to time and to error, all else being the same.

/** -1 where a ratio is below 1 within its interval, 1 where it is above, 0 where that is not told. */
const sideOf = ([, low, high]) => (high !== null && high < 1 ? -1 : low !== null && low > 1 ? 1 : 0);

/** What a setting does, in words, and whether that is good (1), bad (-1) or a trade (0). */
function verdictOf({ kind, time, error }) {
  const [t, e] = [sideOf(time), sideOf(error)];
  if (kind === "measure") return [`${{ "-1": "faster, ", 1: "slower, " }[t] ?? ""}known to ${figure(100 * error[0], 2)} %`, t < 0 ? 0 : -1];
  const words = [{ "-1": "faster", 1: "slower" }[t], { "-1": "better", 1: "worse" }[e]].filter(Boolean);
  const sum = t * e < 0 ? 0 : -Math.sign(t + e);
  if (!words.length) return ["no difference told", 0];
  return [t && e ? words.join(t * e > 0 ? " and " : ", but ") : words[0], sum];
}

const goodMarks = { 1: "✓ ", 0: "", "-1": "✗ " };

function knobRow(knob, widest) {
  const [words, good] = verdictOf(knob);
  const cells = (figures) => [numberCell(figure(figures[0])), rangeCell(figures)];
  const pairs = `${counted(knob.pairs, "pair")} of pictures on ${counted(knob.scenes, "scene")}`;
  return h("tr", { class: good > 0 ? "good" : null },
    h("th", { scope: "row" }, knob.knob, " ", spec(knob.setting), h("span", { class: "soft" }, " against ", spec(knob.baseline))),
    cells(knob.time), cells(knob.error),
    h("td", {}, ratioPicture([knob.time, knob.error], widest)),
    h("td", { class: "verdict" }, goodMarks[good], words),
    h("td", { class: "number", title: pairs }, String(knob.scenes)));
}

function knobTable() {
  const groups_ = new Map();
  for (const knob of trade.knobs) {
    const key = knob.kind === "mode" ? `${knob.renderer} ${knob.form}` : `${knob.renderer} ${knob.form} (${knob.kind})`;
    groups_.set(key, [...(groups_.get(key) ?? []), knob]);
  }
  const widest = widestOf(trade.knobs.flatMap(({ time, error }) => [time, error]));
  const titles = ["Knob and setting", "Time ×", "95 % interval", "RMSE ×", "95 % interval", h("span", { class: "hidden" }, "picture"), "So it is", "Scenes"];
  const bodies = [...groups_].map(([name, knobs]) => h("tbody", { "data-group": name },
    h("tr", { class: "group" }, h("th", { scope: "rowgroup", colspan: 8 }, knobGroup(knobs[0], name))),
    knobs.map((knob) => knobRow(knob, widest))));
  return [
    h("p", {}, "What one setting does to time and to RMSE where all else is the same: the geometric mean of the ratios to the setting it is set against, over scenes and other settings. Below 1 is better. Of measures of point sets RMSE is the width of their bounds over the exact value."),
    scrolled("Knobs", h("table", { class: "plain trade knobs" }, h("caption", { class: "hidden" }, "Ratios of time and of error of each setting"),
      headRow(titles, ["So it is"]), bodies)),
    h("p", { class: "note" }, `In the small pictures, ● is time and ■ error, 1 in the middle, ${figure(widest, 2)} at the right end. ✓ marks what is better in one and not told to be worse in the other, ✗ the opposite.`),
  ];
}

function knobGroup({ renderer }, name) {
  const dot = h("span", { class: "dot", "aria-hidden": "true" });
  dot.style.backgroundColor = colourOf(renderer);
  return [dot, name];
}
