// What a picture costs: CPU time, and what does not depend on the machine.

const costs = {
  cpu: { name: "CPU time", axis: "CPU seconds a picture", against: "time", unit: "CPU seconds", of: (row) => row.cpu },
  samples: { name: "samples", axis: "samples a pixel", against: "samples", unit: "samples a pixel", of: (row) => [row.spp, null] },
  rays: { name: "rays", axis: "rays a pixel", against: "rays", unit: "rays a pixel", of: (row) => [row.rays, null] },
  instructions: {
    name: "instructions", axis: "instructions a picture", against: "instructions", unit: "instructions", of: (row) => [row.instructions, null],
  },
};

/** Those that any picture has a figure of. */
const costNames = Object.keys(costs).filter((name) =>
  name === "cpu" || documentData.scenes.some((scene) => scene.rows.some((row) => costs[name].of(row)[0] > 0)));

/** The ends of a figure's interval of 95 %: its own, else two standard errors; null where it has none. */
function endsOf([value, error, low, high]) {
  if (low !== undefined) return [low, high];
  return error ? [Math.max(0, value - 2 * error), value + 2 * error] : null;
}

/** "0.0114 to 0.0133" of figures and of ratios. */
function rangeText(low, high) {
  if (low === null && high === null) return "";
  if (high === null) return `${figure(low)} or more`;
  return low === null ? `up to ${figure(high)}` : `${figure(low)} to ${figure(high)}`;
}

const trade = documentData.trade;
const tradeOf = (scene) => trade.scenes[scene.name] ?? null;

/** How probable it is that a row is on the front, of its scene or of the pooled ones; null where that is not known. */
const chanceOf = (rows, row) => {
  if (rows === documentData.pooled) return trade.front[identity(row)] ?? null;
  const scene = documentData.scenes.find((each) => each.rows === rows);
  return (scene && tradeOf(scene)?.front[identity(row)]) ?? null;
};

function percent(chance) {
  if (chance > 0 && chance < 0.01) return "under 1\u202f%";
  return chance < 1 && chance > 0.99 ? "over 99\u202f%" : `${Math.round(100 * chance)}\u202f%`;
}
