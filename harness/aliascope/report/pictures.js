// Pictures: decoded when they are first shown, coloured when they are drawn.

const decoded = new Map();
const decodedLimit = 256e6; // bytes; the pictures used longest ago are decoded again when they are needed
let decodedBytes = 0;

/** The picture with a number, in a scene's size: {values, width, height}. `known` is what it was told by. */
async function picture(id, scene, known = async () => nothing) {
  let entry = decoded.get(id);
  if (entry) {
    decoded.delete(id);
  } else {
    const { width, height } = scene;
    const size = width * height * 12;
    decodedBytes += size;
    entry = { size, promise: known().then((told) => decode(id, width, height, told)).then((values) => ({ values, width, height })) };
  }
  decoded.set(id, entry);
  for (const [old, { size }] of decoded) {
    if (decodedBytes <= decodedLimit || old === id) break;
    decoded.delete(old);
    decodedBytes -= size;
  }
  return entry.promise;
}

/** The picture of a row, told by the reference and the relations of its scene; null is the reference. */
function pictureOf(scene, row) {
  const { relations } = scene;
  if (!row) return picture(scene.reference, scene, async () => ({ relations, reference: null }));
  return picture(row.picture, scene, async () => ({ relations, reference: (await pictureOf(scene, null)).values }));
}

/** The samples of each pixel: a picture, one number where all have as many, null for the reference. */
function samplesOf(scene, row) {
  if (!row) return null;
  return row.counts === null ? row.spp : picture(row.counts, scene);
}

/** -log10 of the p-value of each pixel, where a test made them; else null. */
const surpriseOf = (scene, row) => (row && row.surprise !== null ? picture(row.surprise, scene) : null);

// Linear to sRGB (IEC 61966-2-1), rounded to 8 bits.

function srgbByte(linear) {
  const v = clamp(linear, 0, 1);
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}

const notFinite = [255, 0, 255]; // a colour of neither map: a value that is not a number must not pass for one

function paintPicture({ values, width, height }, exposure) {
  const image = new ImageData(width, height);
  const gain = 2 ** exposure;
  for (let i = 0, o = 0; i < values.length; i += 3, o += 4) {
    const finite = Number.isFinite(values[i] + values[i + 1] + values[i + 2]);
    for (let c = 0; c < 3; c++) image.data[o + c] = finite ? srgbByte(values[i + c] * gain) : notFinite[c];
    image.data[o + 3] = 255;
  }
  return image;
}

// Signed error: blue where the picture is darker than the reference, red where it is brighter, neutral at zero.
// Even steps of lightness in Oklab (Ottosson 2020) on both sides, so that no edge appears where the error has none.

const neutral = [0.965, 0, 0];
const darker = [[0.76, -0.04, -0.085], [0.58, -0.04, -0.14], [0.4, -0.02, -0.15]];
const brighter = [[0.76, 0.09, 0.065], [0.58, 0.15, 0.085], [0.4, 0.135, 0.075]];

function oklabToBytes([L, a, b]) {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s_ = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    srgbByte(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s_),
    srgbByte(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s_),
    srgbByte(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s_),
  ];
}

/** The colour of an error as a share of the scale, -1 to 1; beyond, the colour stays. */
function divergingColour(share) {
  const stops = [neutral, ...(share < 0 ? darker : brighter)];
  const at = Math.min(Math.abs(share), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(at), stops.length - 2);
  return oklabToBytes(stops[low].map((value, i) => value + (at - low) * (stops[low + 1][i] - value)));
}

const halfSteps = 256; // even, so that 0 has a colour of its own
const divergingTable = Array.from({ length: 2 * halfSteps + 1 }, (_, i) => divergingColour(i / halfSteps - 1));

function errorColour(error, scale) {
  if (!Number.isFinite(error)) return notFinite;
  return divergingTable[Math.round(halfSteps * (1 + clamp(error / scale, -1, 1)))];
}

/** The signed error of a pixel: the mean over the channels of picture - reference. */
function signedError(values, reference, i) {
  return (values[i] - reference[i] + (values[i + 1] - reference[i + 1]) + (values[i + 2] - reference[i + 2])) / 3;
}

function paintError({ values, width, height }, reference, scale) {
  const image = new ImageData(width, height);
  for (let i = 0, o = 0; i < values.length; i += 3, o += 4) {
    image.data.set(errorColour(signedError(values, reference.values, i), scale), o);
    image.data[o + 3] = 255;
  }
  return image;
}

// Samples of each pixel: even steps of lightness for even ratios, dark where few were enough.

const magnitudeLow = [0.2, 0.01, -0.09];
const magnitudeMiddle = [0.6, 0.0, -0.02];
const magnitudeHigh = [0.96, -0.02, 0.12];

/** The colour of a share of a scale, 0 to 1. */
function magnitudeColour(share) {
  const [low, high] = share < 0.5 ? [magnitudeLow, magnitudeMiddle] : [magnitudeMiddle, magnitudeHigh];
  const at = share < 0.5 ? 2 * share : 2 * share - 1;
  return oklabToBytes(low.map((value, i) => value + at * (high[i] - value)));
}

/** The colour of a number of samples, 1 to `most`. */
const samplesColour = (count, most) => magnitudeColour(clamp(Math.log(Math.max(count, 1)) / Math.log(Math.max(most, 2)), 0, 1));

/** `samples` as a picture, or one number for all pixels of a scene. */
function paintSamples(samples, { width, height }, most) {
  const image = new ImageData(width, height);
  for (let i = 0, o = 0; o < image.data.length; i += 3, o += 4) {
    image.data.set(samplesColour(typeof samples === "number" ? samples : samples.values[i], most), o);
    image.data[o + 3] = 255;
  }
  return image;
}

/** The scale of a map of magnitudes, printed. */
function magnitudeLegend(low, middle, high) {
  const bar = h("span", { class: "bar", "aria-hidden": "true" });
  const colours = Array.from({ length: 33 }, (_, i) => `rgb(${magnitudeColour(i / 32).join(" ")})`);
  bar.style.backgroundImage = `linear-gradient(to right, ${colours.join(", ")})`;
  return h(
    "p",
    { class: "error-legend" },
    h("span", { class: "end" }, low),
    h("span", { class: "middle" }, bar, h("small", {}, middle)),
    h("span", { class: "end" }, high),
  );
}

/** The scale of the samples; for all modes of a scene it is the same. */
const samplesLegend = (most) =>
  magnitudeLegend(["1", h("small", {}, "sample")], String(Number(Math.sqrt(most).toPrecision(2))), [String(most), h("small", {}, "samples")]);

// p-values: dark where chance explains the difference, bright where it does not. A picture has some ten thousand of them,
// so that one in 10^4 is there by chance.

const mostSurprising = 10; // powers of ten

const pValueText = (surprise) => (surprise === 0 ? "1" : scientific(10 ** -surprise, 1));

/** The p-values of a picture that a test was made of; of another, nothing. */
function paintSurprise(surprise, { width, height }) {
  const image = new ImageData(width, height);
  if (!surprise) return image;
  for (let i = 0, o = 0; o < image.data.length; i += 3, o += 4) {
    const value = surprise.values[i];
    image.data.set(Number.isFinite(value) ? magnitudeColour(clamp(value / mostSurprising, 0, 1)) : notFinite, o);
    image.data[o + 3] = 255;
  }
  return image;
}

const surpriseLegend = () =>
  magnitudeLegend(["p = 1", h("small", {}, "by chance")], `10${superscript(-mostSurprising / 2)}`, [`10${superscript(-mostSurprising)}`, h("small", {}, "or less")]);

/** A picture averaged over squares of `factor` pixels, for a thumbnail. */
function shrink({ values, width, height }, factor) {
  if (factor === 1) return { values, width, height };
  const [w, h_] = [Math.ceil(width / factor), Math.ceil(height / factor)];
  const sums = new Float64Array(3 * w * h_);
  const counts = new Float64Array(w * h_);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const to = Math.floor(y / factor) * w + Math.floor(x / factor);
      counts[to]++;
      for (let c = 0; c < 3; c++) sums[3 * to + c] += values[3 * (y * width + x) + c];
    }
  }
  return { values: sums.map((sum, i) => sum / counts[Math.floor(i / 3)]), width: w, height: h_ };
}

/** The scale of the error maps of a scene: the reader's, else the one from the data. */
const scaleOf = (scene) => (scene.name === state.scene && state.scale ? state.scale : scene.scale);

/** The scale of the error maps, printed: a bar of its colours between its ends. */
function errorLegend(scale) {
  const bar = h("span", { class: "bar", "aria-hidden": "true" });
  const colours = Array.from({ length: 33 }, (_, i) => `rgb(${divergingColour(i / 16 - 1).join(" ")})`);
  bar.style.backgroundImage = `linear-gradient(to right, ${colours.join(", ")})`;
  return h(
    "p",
    { class: "error-legend" },
    h("span", { class: "end" }, `\u2212${roundFigure(scale)}`, h("small", {}, "darker")),
    h("span", { class: "middle" }, bar, h("small", {}, "0")),
    h("span", { class: "end" }, `+${roundFigure(scale)}`, h("small", {}, "brighter")),
  );
}
