// Elements, numbers and names. Text from the data reaches the page as text nodes and attributes only.

const svgSpace = "http://www.w3.org/2000/svg";

function build(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") node.addEventListener(name, value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return node;
}

const h = (tag, attributes, ...children) => build(document.createElement(tag), attributes, children);
const s = (tag, attributes, ...children) => build(document.createElementNS(svgSpace, tag), attributes, children);

/** A spec, which may break after its commas and colons. */
function spec(text) {
  const parts = text.split(/(?<=[,:])/).flatMap((part) => [part, h("wbr")]);
  return h("span", { class: "spec" }, parts.slice(0, -1));
}

/** A mode as people read it; its spec is what it is chosen by. */
const modeName = (row) => {
  const parts = row.label.split(/(?<=[,:])/).flatMap((part) => [part, h("wbr")]);
  return h("span", { class: "mode-name", title: row.mode }, parts.slice(0, -1));
};

const readable = (row) => `${row.renderer} ${row.label}`;

const identity = (row) => `${row.renderer} ${row.mode}`;

// Colours and markers: a colour for each renderer, a shape for each family of it.

const colourOf = (renderer) => documentData.colours[renderer] ?? "#777777";

const shapes = [
  "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z",
  "M-3.6-3.6h7.2v7.2h-7.2z",
  "M0-4.8 4.6 3.4h-9.2z",
  "M0-5.2 5.2 0 0 5.2-5.2 0z",
  "M0 4.8 4.6-3.4h-9.2z",
  "M-1.5-4.6h3v3.1h3.1v3h-3.1v3.1h-3v-3.1h-3.1v-3h3.1z",
  "M0-5 4.8-1.5 2.9 4.1h-5.8L-4.8-1.5z",
  "M-4.6-2.5-2.5-4.6 0-2.1 2.5-4.6 4.6-2.5 2.1 0 4.6 2.5 2.5 4.6 0 2.1-2.5 4.6-4.6 2.5-2.1 0z",
];

const familyShapes = new Map();
for (const [renderer, family] of documentData.families) {
  const before = documentData.families.filter(([name]) => name === renderer);
  const index = before.findIndex(([, name]) => name === family);
  familyShapes.set(`${renderer}\n${family}`, shapes[index % shapes.length]);
}
const shapeOf = (row) => familyShapes.get(`${row.renderer}\n${row.family}`) ?? shapes[0];

/** The marker of a row beside its name. */
function marker(row) {
  const path = s("path", { d: shapeOf(row), fill: colourOf(row.renderer) });
  return s("svg", { class: "marker", viewBox: "-6 -6 12 12", width: 12, height: 12, "aria-hidden": "true" }, path);
}

const familyName = (renderer, family) =>
  family.startsWith(`${renderer} `) ? family.slice(renderer.length + 1) : family;

// Numbers: three significant digits where they are compared, all of them where a pixel is read out.

const minus = (text) => text.replace(/^-/, "\u2212");

function exponent(value) {
  return value === 0 ? 0 : Number(value.toExponential(2).split("e")[1]);
}

const superscript = (number) => [...String(number)].map((c) => (c === "-" ? "\u207b" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");

function scientific(value, digits = 3) {
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  return `${minus(mantissa)}\u202f×\u202f10${superscript(Number(power))}`;
}

/** Decimals that give `digits` significant digits. */
const decimalsFor = (value, digits = 3) => Math.max(0, digits - 1 - exponent(value));

const groups = (text) => (/^\d{5,}$/.test(text) ? text.replace(/\B(?=(\d{3})+$)/g, "\u202f") : text);

function figure(value, digits = 3) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const power = exponent(value);
  if (power < -5 || power >= 7) return scientific(value, digits);
  const rounded = Number(value.toPrecision(digits));
  return value < 0
    ? `\u2212${groups((-rounded).toFixed(decimalsFor(value, digits)))}`
    : groups(rounded.toFixed(decimalsFor(value, digits)));
}

/** A round number, such as the end of a scale, without more digits than it has. */
const roundFigure = (value) => (value < 1e-4 || value >= 1e6 ? scientific(value, 1) : String(Number(value.toPrecision(3))));

/** A figure without digits far below its uncertainty: 0.0000935 ± 0.0012 is 0.0001. */
function estimated(value, error) {
  const most = error ? Math.max(0, -exponent(error)) + 1 : Infinity;
  if (!value || most > 7 || decimalsFor(value) <= most) return figure(value);
  const text = Math.abs(value).toFixed(most);
  return value < 0 && Number(text) !== 0 ? `\u2212${text}` : text;
}

/** The uncertainty of a figure, to its last digit or to one digit of its own where that is finer. */
function uncertainty(value, error) {
  if (error === null || error === undefined) return "";
  if (error === 0) return "± 0";
  const power = exponent(error);
  if (power < -6 || power >= 7) return `± ${scientific(error, 1)}`;
  if (power >= 2) return `± ${groups(Number(error.toPrecision(1)).toFixed(0))}`;
  const own = Math.max(0, -power);
  const shared = value ? decimalsFor(value) : own;
  return `± ${error.toFixed(clamp(shared, own, own + 1))}`;
}

/** A linear value of a picture: six significant digits; NaN and the infinities by name. */
function pixelValue(value, signed = false) {
  if (Number.isNaN(value)) return "NaN";
  if (!Number.isFinite(value)) return value < 0 ? "\u2212∞" : signed ? "+∞" : "∞";
  const sign = value < 0 || Object.is(value, -0) ? "\u2212" : signed && value > 0 ? "+" : "";
  const size = Math.abs(value);
  if (size === 0) return signed ? "0" : `${sign}0`;
  const digits = signed ? 5 : 6; // a difference has lost some
  if (size < 1e-3 || size >= 1e6) return sign + size.toExponential(digits - 1).replace("-", "\u2212").replace("+", "");
  return sign + size.toFixed(Math.max(0, digits - 1 - Math.floor(Math.log10(Number(size.toPrecision(digits))))));
}

/** Pads a column of figures with spaces of a digit's and a point's width, so that the points stand in line. */
function alignPoints(texts) {
  const tails = texts.map((text) => (/^[^×]*\.(\d+)$/.exec(text)?.[1].length ?? 0));
  const longest = Math.max(0, ...tails);
  return texts.map((text, i) => {
    if (text.includes("×") || !/\d/.test(text)) return text;
    const point = longest > 0 && tails[i] === 0 ? "\u2008" : "";
    return text + point + "\u2007".repeat(longest - tails[i]);
  });
}

/** CPU seconds; a renderer whose clock goes in steps may tell 0, which is no time that a picture takes. */
const timeFigure = (seconds) => (seconds === 0 ? "too short" : figure(seconds));

const counted = (n, thing) => `${n} ${thing}${n === 1 ? "" : "s"}`;

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

function announce(text) {
  document.getElementById("live").textContent = text;
}
