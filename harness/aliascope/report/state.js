// What is shown, all of it in the fragment of the URL: a link shows what was seen.

const withSamples = documentData.scenes.some((scene) => scene.mostSamples !== null);
const withTests = documentData.scenes.some((scene) => scene.rows.some((row) => row.surprise !== null));
const views = [
  "side", "slider", "blink", "error-a", "error-b", "errors", ...(withSamples ? ["samples-a"] : []), ...(withTests ? ["p-values-a"] : []),
];
const viewNames = {
  side: "A | B", slider: "slider", blink: "blink",
  "error-a": "error A", "error-b": "error B", errors: "errors A | B", "samples-a": "samples A",
  "p-values-a": "p-values A",
};
const referenceName = "reference";
const tradeTabs = ["error", "time", "rate", "scenes", "knobs"];
const sceneByName = new Map(documentData.scenes.map((scene) => [scene.name, scene]));
const state = {};
const listeners = [];

/** The row that A or B names in a scene; null is the reference. */
function rowOf(scene, name) {
  return name === referenceName ? null : scene.rows.find((row) => identity(row) === name);
}

const currentScene = () => sceneByName.get(state.scene);

/** B: the most efficient mode. A: another renderer's that takes about as long. */
function defaultPair(scene) {
  const efficiency = (row) => efficiencyOf(row)[0] ?? -1;
  const best = scene.rows.reduce((a, b) => (a && efficiency(a) >= efficiency(b) ? a : b), null);
  if (!best) return [referenceName, referenceName];
  const apart = (row) => Math.abs(Math.log((row.cpu[0] || 1e-9) / (best.cpu[0] || 1e-9)));
  const others = scene.rows.filter((row) => row.renderer !== best.renderer);
  const rest = others.length ? others : scene.rows.filter((row) => row !== best);
  const near = rest.reduce((a, b) => (a && apart(a) <= apart(b) ? a : b), null);
  return [near ? identity(near) : referenceName, identity(best)];
}

const numberIn = (text, low, high) => {
  const value = text === null || text === "" ? NaN : Number(text);
  return Number.isFinite(value) ? clamp(value, low, high) : null;
};

/** "2,5" of those that there are; null for none. */
const listOf = (text, allowed) => allowed.filter((name) => (text ?? "").split(",").includes(name)).join(",") || null;

/** A list of the state with a name put in or taken out. */
function withName(text, name, there) {
  const names = (text ?? "").split(",").filter((other) => other && other !== name);
  return [...names, ...(there ? [name] : [])].join(",") || null;
}

/** The state that a fragment names; what it leaves out or gets wrong is as at the start. */
function parseState(fragment) {
  const given = new URLSearchParams(fragment.replace(/^#/, ""));
  const choice = (key, allowed, otherwise) => (allowed.includes(given.get(key)) ? given.get(key) : otherwise);
  const first = documentData.scenes[0];
  if (!first) return { metric: defaultMetric };
  const scene = sceneByName.get(given.get("scene")) ?? first;
  const [a, b] = defaultPair(scene);
  const picked = (key, otherwise) => (rowOf(scene, given.get(key)) !== undefined ? given.get(key) : otherwise);
  const chosen = { a: picked("a", a), b: picked("b", b) };
  const worst = (rowOf(scene, chosen.a) ?? rowOf(scene, chosen.b))?.worst ?? [0, 0];
  const whole = (value) => (value === null ? null : Math.round(value));
  return {
    scene: scene.name,
    ...chosen,
    view: choice("view", views, "side"),
    zoom: whole(numberIn(given.get("zoom"), 1, 64)),
    x: whole(numberIn(given.get("x"), 0, scene.width - 1)) ?? worst[0],
    y: whole(numberIn(given.get("y"), 0, scene.height - 1)) ?? worst[1],
    cx: numberIn(given.get("cx"), 0, scene.width),
    cy: numberIn(given.get("cy"), 0, scene.height),
    split: numberIn(given.get("split"), 0, 1) ?? 0.5,
    exposure: numberIn(given.get("exposure"), -10, 10) ?? 0,
    scale: numberIn(given.get("scale"), 1e-9, 1e9),
    metric: choice("metric", metricNames, defaultMetric),
    sort: /^(mode|error|spp|cpu|efficiency|pictures)-(up|down)$/.test(given.get("sort") ?? "") ? given.get("sort") : "error-up",
    over: given.get("over") === "scene" ? "scene" : "all",
    cost: choice("cost", costNames, "cpu"),
    trade: choice("trade", tradeTabs, tradeTabs[0]),
    reach: numberIn(given.get("reach"), 0, 1e12),
    afford: numberIn(given.get("afford"), 0, 1e12),
    time: numberIn(given.get("time"), 1e-12, 1e12),
    error: numberIn(given.get("error"), -1e12, 1e12),
    hidden: listOf(given.get("hidden"), documentData.families.map((_, i) => String(i))),
    opened: listOf(given.get("opened"), ["pooled", "filters"]),
  };
}

function fragmentOf(values) {
  const out = new URLSearchParams();
  const usual = { view: "side", split: 0.5, exposure: 0, metric: defaultMetric, sort: "error-up", over: "all", cost: "cpu", trade: tradeTabs[0] };
  for (const [key, value] of Object.entries(values)) {
    if (value === null || value === undefined || value === usual[key]) continue;
    out.set(key, typeof value === "number" ? String(Number(value.toPrecision(8))) : value);
  }
  return `#${out.toString().replaceAll("%3A", ":").replaceAll("%2C", ",").replaceAll("%3D", "=")}`;
}

let writing = 0;

/** Changes the state and tells everything that shows it which keys have changed. */
function change(patch) {
  const changed = new Set(Object.keys(patch).filter((key) => state[key] !== patch[key]));
  if (!changed.size) return;
  Object.assign(state, patch);
  for (const listen of listeners) listen(changed);
  // Browsers limit how often a page may write its address; a drag would pass that.
  clearTimeout(writing);
  writing = setTimeout(writeFragment, 120);
}

function writeFragment() {
  clearTimeout(writing);
  writing = 0;
  history.replaceState(null, "", fragmentOf(state));
}

const onChange = (listen) => listeners.push(listen);

/** What A and B are in a scene, or would be: those of now, where it has them. */
function pairIn(scene) {
  const [a, b] = defaultPair(scene);
  const kept = (now, otherwise) => (rowOf(scene, now) !== undefined ? now : otherwise);
  return { a: kept(state.a, a), b: kept(state.b, b) };
}

function chooseScene(name) {
  if (name === state.scene) return;
  const scene = sceneByName.get(name);
  const next = pairIn(scene);
  const [x, y] = (rowOf(scene, next.a) ?? rowOf(scene, next.b))?.worst ?? [0, 0];
  change({ scene: name, ...next, x, y, cx: null, cy: null, zoom: null, scale: null });
}

/** Puts a mode into A or B, where the scene has it: returns whether it has. `also` is changed with it. */
function choose(slot, name, also = {}) {
  const row = rowOf(currentScene(), name);
  if (row === undefined) {
    announce(`${name} has no picture of ${state.scene}`);
    return false;
  }
  change({ [slot]: name, ...also });
  announce(`${slot.toUpperCase()}: ${row ? readable(row) : name}`);
  return true;
}

/** Brings the pictures into sight, and gives them the keys. */
function showPictures() {
  const stage = document.querySelector(".stage");
  stage?.focus({ preventScroll: true });
  stage?.closest(".viewer").scrollIntoView({ block: "start" });
}
