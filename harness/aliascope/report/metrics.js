// What each metric is called, and how it is plotted: as a badness, of which less is better.

const same = (value) => value;

/** How the values of a metric are plotted: `MetricInfo` of records.py says what it is. */
function plottedAs({ label, better, best, signed }, title) {
  if (better === "zero") return { plotted: `|${label}|`, linear: false, badness: Math.abs, value: same };
  if (better === "less") return { plotted: title, linear: signed, badness: same, value: same };
  if (best === null) return { plotted: title, linear: true, badness: (v) => -v, value: (b) => -b };
  return { plotted: `${best} − ${label}`, linear: false, badness: (v) => best - v, value: (b) => best - b };
}

const nothingMeasured = { label: "error", unit: "", better: "less", best: null, signed: false, axis: "" };

function metricOf(name) {
  const about = documentData.metrics[name] ?? nothingMeasured;
  const { label, unit, better, axis } = about;
  const title = unit ? `${label}, ${unit}` : label;
  const { plotted, ...rest } = plottedAs(about, title);
  return { name, label, unit, title, more: better === "more", plotted: axis || plotted, ...rest };
}

const measured = Object.keys(documentData.metrics);
const metricNames = measured.length ? measured : ["error"]; // a report whose jobs have all failed
const defaultMetric = metricNames.includes("rmse") ? "rmse" : metricNames[0];

const estimateOf = (row, name) => row.metrics[name] ?? [null, null];

/** What a row is plotted and sorted by, less is better; null where it has no figure. PSNR without error is -Infinity. */
function badnessOf(row, metric) {
  const [value] = estimateOf(row, metric.name);
  if (value === null) return metric.name === "psnr" && estimateOf(row, "rmse")[0] === 0 ? -Infinity : null;
  return metric.badness(value);
}

/** 1 / (MSE * CPU seconds) and its standard error; nulls where it has none. */
function efficiencyOf(row) {
  const [rmse, rmseError] = estimateOf(row, "rmse");
  const [seconds, secondsError] = row.cpu;
  if (!rmse || !seconds) return [null, null];
  const value = 1 / (rmse * rmse * seconds);
  if (!Number.isFinite(value)) return [null, null];
  const relative = rmseError === null || secondsError === null
    ? null : Math.hypot((2 * rmseError) / rmse, secondsError / seconds);
  return [value, relative === null ? null : value * relative];
}

/** Whether figures [value, standard error] cannot be told apart: as `told_apart` of statistics.py has it. */
const tellingErrors = 2;
const alike = ([a, aError], [b, bError]) => Math.abs(a - b) <= tellingErrors * Math.hypot(aError ?? 0, bError ?? 0);

/** The rows that no other beats in both cost and badness, by rising cost. Those that lack a scene don't take part. */
function paretoFront(rows, metric, costOf = (row) => row.cpu) {
  const points = rows
    .filter((row) => row.missing.length === 0 && costOf(row)[0] > 0 && badnessOf(row, metric) !== null)
    .map((row) => ({ row, time: costOf(row)[0], badness: badnessOf(row, metric) }))
    .sort((a, b) => a.time - b.time || a.badness - b.badness);
  const front = [];
  for (const point of points) {
    if (!front.length || point.badness < front[front.length - 1].badness) front.push(point);
  }
  return front;
}

/** "RMSE 0.0123 ± 0.0004" */
function metricText(row, metric) {
  const [value, error] = estimateOf(row, metric.name);
  const unit = metric.unit ? ` ${metric.unit}` : "";
  return `${metric.label} ${estimated(value, error)}${error === null ? "" : ` ${uncertainty(value, error).replace(" ", "\u00a0")}`}${unit}`;
}
