// The page: scenes as tabs, one viewer that goes from one to the next, keys, and the fragment of the URL.

Object.assign(state, parseState(location.hash));

const plots = [];
const tables = [];
const spectra = [];
const panels = new Map();

function buildScene(scene, index) {
  const tab = h("button",
    { type: "button", role: "tab", id: `tab-${index}`, "aria-controls": `scene-${index}`, click: () => chooseScene(scene.name) }, scene.name);
  const [viewerPlace, spectrumPlace] = [h("div"), h("div")];
  const [tableHost, plotHost, sheetHost] = [h("div", { class: "table-host" }), h("div", { class: "figure" }), h("div")];
  const heading = h("header", { class: "scene-head" }, h("h3", {}, scene.title || scene.name),
    h("p", {}, scene.shows, " ", h("span", { class: "soft" }, `${scene.width} × ${scene.height} pixels.`)));
  const node = h("section", { class: "scene", role: "tabpanel", id: `scene-${index}`, "aria-labelledby": `tab-${index}` }, heading);
  const panel = { scene, tab, node, viewerPlace, sheet: null, table: null };
  if (scene.rows.length) {
    node.append(viewerPlace, spectrumPlace, h("div", { class: "figures" }, tableHost, h("div", { class: "side-figure" }, plotHost)));
    panel.table = new ModeTable(tableHost, scene.rows, `Modes on ${scene.name}`, true);
    tables.push(panel.table);
    tableHost.append(lackingList(scene) ?? "");
    plots.push(new Plot(plotHost, scene.rows, scene.name));
    spectra.push(new Spectrum(spectrumPlace, scene));
    panel.sheet = new Sheet(sheetHost, scene);
    node.append(sheetHost);
  } else {
    node.append(h("p", { class: "notice" }, "No picture of this scene was measured."), lackingList(scene) ?? "");
  }
  panels.set(scene.name, panel);
  return panel;
}

function buildScenes(host) {
  const built = documentData.scenes.map(buildScene);
  const tabs = h("div", { class: "tabs", role: "tablist", "aria-label": "Scenes" }, built.map(({ tab }) => tab));
  tabs.addEventListener("keydown", (event) => {
    const now = built.findIndex(({ scene }) => scene.name === state.scene);
    const next = { ArrowRight: now + 1, ArrowLeft: now - 1, Home: 0, End: built.length - 1 }[event.key];
    if (next === undefined) return;
    const { scene, tab } = built[(next + built.length) % built.length];
    chooseScene(scene.name);
    tab.focus();
    event.preventDefault();
    event.stopPropagation();
  });
  host.append(tabs, ...built.map(({ node }) => node));
}

function showScene(viewer) {
  for (const { scene, tab, node, viewerPlace } of panels.values()) {
    const current = scene.name === state.scene;
    tab.setAttribute("aria-selected", String(current));
    tab.setAttribute("tabindex", current ? "0" : "-1");
    node.hidden = !current;
    if (current && scene.rows.length) viewerPlace.append(viewer.node);
  }
  viewer.load();
}

/** The contact sheet in sight at once, the others when there is time: they are printed too. */
async function drawSheets() {
  const current = panels.get(state.scene)?.sheet;
  await current?.draw();
  for (const { sheet } of panels.values()) {
    if (!sheet || sheet.drawn) continue;
    await new Promise((resume) => requestIdleCallback(resume, { timeout: 500 }));
    await sheet.draw();
  }
  document.documentElement.dataset.ready = "true";
}

function update(changed, viewer) {
  if (changed.has("scene")) showScene(viewer);
  if (changed.has("metric") || changed.has("cost")) plots.forEach((plot) => plot.draw());
  if (changed.has("metric") || changed.has("sort")) tables.forEach((table) => table.draw());
  if (["a", "b", "scene", "metric"].some((key) => changed.has(key))) {
    plots.forEach((plot) => plot.mark());
    tables.forEach((table) => table.mark());
    panels.forEach(({ sheet }) => sheet?.mark());
    spectra.forEach((spectrum) => spectrum.mark());
  }
  if (["scene", "exposure", "scale"].some((key) => changed.has(key))) drawSheets();
}

/** Keys act everywhere but where the page is typed into; arrows and space only on the pictures, since they scroll. */
function keys(event, viewer) {
  if (event.ctrlKey || event.metaKey || event.altKey || !viewer.loaded) return;
  const { target } = event;
  const typing = target.closest?.("input:not([type=radio]), select, textarea");
  if (typing || (target.closest?.("input[type=radio]") && event.key.startsWith("Arrow"))) return;
  const onPictures = viewer.stage.contains(document.activeElement) || viewer.stage.matches(":hover");
  const onButton = target.closest?.("button, summary, a, input");
  const digit = /^Digit([1-9])$/.exec(event.code)?.[1] ?? (/^[1-9]$/.test(event.key) ? event.key : null);
  const step = event.shiftKey ? 10 : 1;
  const arrows = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
  if (digit) {
    const row = panels.get(state.scene).table?.sorted[Number(digit) - 1];
    if (row) choose(event.shiftKey ? "b" : "a", identity(row));
  } else if (event.key in arrows && onPictures) viewer.walk(...arrows[event.key]);
  else if (event.key === " " && onPictures && !onButton) viewer.blink();
  else if (event.key === "e") viewer.nextError();
  else if (event.key === "s") viewer.toggleSamples();
  else if (event.key === "p") viewer.togglePValues();
  else if (event.key === "r") viewer.toggleReference();
  else if (event.key === "m" || event.key === "M") viewer.worst(event.shiftKey ? "b" : "a");
  else if (event.key === "+" || event.key === "=") viewer.zoomBy(1);
  else if (event.key === "-") viewer.zoomBy(-1);
  else if (event.key === "0") viewer.fit();
  else return;
  event.preventDefault();
}

function copyButtons() {
  for (const button of document.querySelectorAll("button.copy")) {
    button.addEventListener("click", async () => {
      const code = button.previousElementSibling;
      try {
        await navigator.clipboard.writeText(code.textContent);
        button.textContent = "copied";
      } catch {
        getSelection().selectAllChildren(code); // without leave to copy: select it for the reader to
      }
    });
  }
}

/** A table that is opened and closed; the state says whether it is. */
function keepOpened(name, details) {
  if (!details) return;
  const show = () => (details.open = (state.opened ?? "").split(",").includes(name));
  details.addEventListener("toggle", () => change({ opened: withName(state.opened, name, details.open) }));
  onChange((changed) => changed.has("opened") && show());
  show();
}

/** Which scenes the overview leaves out, and why. */
function leftOut() {
  const names = documentData.scenes.map(({ name }) => name).filter((name) => !documentData.pooledScenes.includes(name));
  if (!names.length) return [];
  return [h("p", { class: "note" }, `Over the scenes that every renderer drew in much the same modes, under one filter: without ${names.join("; ")}.`)];
}

/** To what a link of the page shows: a scene, and how it is looked at. */
function followLink() {
  if (!location.hash.includes("=")) return;
  change(parseState(location.hash));
  document.getElementById("see").scrollIntoView();
}

function start() {
  copyButtons();
  if (!documentData.scenes.length) return;
  buildScenes(document.getElementById("scenes"));
  const overview = document.getElementById("overview-plot");
  const pooled = new Plot(overview, scopeRows(), scopeName);
  plots.unshift(pooled);
  const heading = h("h3");
  overview.prepend(h("div", { class: "figure-head" }, heading, plotChoosers(pooled, heading)));
  overview.append(...leftOut());
  new Chooser(document.getElementById("choose"));
  legend(document.getElementById("legend"), plots);
  tables.push(new ModeTable(document.getElementById("pooled"), documentData.pooled, `Modes over ${scopeName}`, false));
  plots.forEach((plot) => plot.draw());
  spectra.forEach((spectrum) => spectrum.draw());
  const tables_ = document.getElementById("trade-tables");
  if (tables_ && tabsOfTrade().length) new TradeTables(tables_);
  else tables_?.closest("section").remove();
  const filters = document.getElementById("filter-panels");
  if (filters) new Filters(filters, documentData.filters);
  keepOpened("pooled", document.getElementById("pooled"));
  keepOpened("filters", filters?.querySelector("details"));
  const viewer = new Viewer();
  onChange((changed) => update(changed, viewer));
  showScene(viewer);
  update(new Set(["a"]), viewer);
  drawSheets();
  document.addEventListener("keydown", (event) => keys(event, viewer));
  addEventListener("pagehide", () => writing && writeFragment());
  addEventListener("hashchange", () => followLink());
  const [visit] = performance.getEntriesByType("navigation");
  if (location.hash.includes("scene=") && visit?.type === "navigate") document.getElementById("see").scrollIntoView();
}

start();
