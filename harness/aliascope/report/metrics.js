// What each metric is called, and how it is plotted: as a badness, of which less is better.

const known = {
  rmse: { label: "RMSE" },
  mae: { label: "mean |error|" },
  bias: { label: "bias", plotted: "|bias|", badness: Math.abs },
  psnr: { label: "PSNR", unit: "dB", linear: true, badness: (v) => -v, value: (b) => -b, more: true },
  "relative-mse": { label: "relative MSE" },
  max: { label: "largest |error|" },
  p99: { label: "99th percentile of |error|" },
  ssim: { label: "SSIM", plotted: "1 − SSIM", badness: (v) => 1 - v, value: (b) => 1 - b, more: true },
  flip: { label: "FLIP" },
  structure: { label: "structure", plotted: "structure of the error (0: noise)", linear: true },
};

const same = (value) => value;

function metricOf(name) {
  const { label = name, unit = "", plotted, linear = false, badness = same, value = same, more = false } =
    known[name] ?? {};
  const title = unit ? `${label}, ${unit}` : label;
  return { name, label, unit, title, plotted: plotted ?? title, linear, badness, value, more };
}

const metricNames = documentData.metrics.length ? documentData.metrics : ["rmse"];
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

/** The rows that no other beats in both time and badness, by rising time. Those that lack a scene don't take part. */
function paretoFront(rows, metric) {
  const points = rows
    .filter((row) => row.missing.length === 0 && row.cpu[0] > 0 && badnessOf(row, metric) !== null)
    .map((row) => ({ row, time: row.cpu[0], badness: badnessOf(row, metric) }))
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
  return `${metric.label} ${figure(value)}${error === null ? "" : ` ${uncertainty(value, error)}`}${unit}`;
}
