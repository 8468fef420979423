// Pictures from their text, to the bit: `packing.py` says how they are stored, `encode.py` how as characters.

const nothing = { relations: { lines: [], planes: [] }, reference: null };
const [paletteKind, toldKind, stepsKind] = [1, 2, 4];
const sameLabel = 255;
const mostSteps = 2 ** 24;

const characterValues = new Uint8Array(128);
for (let code = 33, value = 0; code < 127; code++) if (!"&<>".includes(String.fromCharCode(code))) characterValues[code] = value++;

/** Two characters hold 13 bits, a last one 6. */
function bytesOf(text) {
  const whole = text.length >> 1;
  const bytes = new Uint8Array((13 * whole + 6 * (text.length & 1)) >> 3);
  let [held, bits, at] = [0, 0, 0];
  for (let i = 0; i < text.length; i += 2) {
    const first = characterValues[text.charCodeAt(i)];
    const single = i + 1 === text.length;
    held = single ? (held << 6) | first : (held << 13) | (91 * first + characterValues[text.charCodeAt(i + 1)]);
    bits += single ? 6 : 13;
    for (; bits >= 8; bits -= 8) bytes[at++] = held >> (bits - 8);
    held &= (1 << bits) - 1;
  }
  return bytes;
}

async function inflate(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

const oneFloat = new Float32Array(1);
const itsBits = new Int32Array(oneFloat.buffer);

function bitsOf(value) {
  oneFloat[0] = value;
  return itsBits[0];
}

function floatOf(bits) {
  itsBits[0] = bits;
  return oneFloat[0];
}

/** Between values and integers in their order: the bits of floats, or numbers of steps. */
function ordinalsOf(step) {
  if (!step) return { of: bitsOf, ofBits: same, value: floatOf, bits: same };
  const of = (value) => (Number.isNaN(value) ? 0 : clamp(Math.floor(value / step + 0.5), -mostSteps, mostSteps));
  return { of, ofBits: (bits) => of(floatOf(bits)), value: (k) => Math.fround(k * step), bits: (k) => bitsOf(k * step) };
}

/** Takes bytes from the front. */
class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer);
    this.at = 0;
  }

  take(count) {
    this.at += count;
    return this.bytes.subarray(this.at - count, this.at);
  }

  /** Differences 0, -1, 1, ... in planes, highest byte first. */
  signed(count, planes) {
    const found = new Int32Array(count);
    for (let plane = 0; plane < planes; plane++) {
      const bytes = this.take(count);
      for (let i = 0; i < count; i++) found[i] = (found[i] << 8) | bytes[i];
    }
    for (let i = 0; i < count; i++) found[i] = (found[i] >>> 1) ^ -(found[i] & 1);
    return found;
  }
}

/** The bits of `count` pixels, Int32Array [count][3]. Without `colours` they are those: red is told from the one before. */
function readPixels(reader, count, ordinals, { lines, planes }, { reference, colours, told }) {
  const labels = reader.take(count);
  const related = lines.length + planes.length;
  let [none, onLine, onPlane] = [0, 0, 0];
  for (const label of labels) {
    if (label === 0) none++;
    else if (label <= lines.length) onLine++;
    else if (label <= related) onPlane++;
  }
  const red = reader.signed(none + onLine + onPlane, 4);
  const [greenFar, blueFar] = [reader.signed(none + onPlane, 4), reader.signed(none, 4)];
  const [greenNear, blueNear] = [reader.signed(onLine, 1), reader.signed(onLine + onPlane, 1)];
  const found = new Int32Array(3 * count);
  const at = { red: 0, greenFar: 0, blueFar: 0, greenNear: 0, blueNear: 0 };
  let before = 0;
  for (let i = 0, o = 0; i < count; i++, o += 3) {
    const label = labels[i];
    if (label > related) {
      const [source, from] = label === sameLabel ? [reference, o] : [colours, 3 * (label - related - 1)];
      for (let c = 0; c < 3; c++) found[o + c] = source[from + c];
      continue;
    }
    const [r0, r1, r2] = told ? [0, 1, 2].map((c) => ordinals.ofBits(reference[o + c])) : [colours ? 0 : before, 0, 0];
    const [g0, b0] = told ? [r1 - r0, r2 - r0] : [0, 0];
    const k = (red[at.red++] + r0) | 0;
    before = k;
    const value = ordinals.value(k);
    let [green, blue] = [0, 0];
    if (label > 0 && label <= lines.length) {
      const line = lines[label - 1];
      green = (greenNear[at.greenNear++] + ordinals.of(line[0] + line[1] * value)) | 0;
      blue = (blueNear[at.blueNear++] + ordinals.of(line[2] + line[3] * value)) | 0;
    } else {
      green = (greenFar[at.greenFar++] + k + g0) | 0;
      if (label > 0) {
        const plane = planes[label - lines.length - 1];
        blue = (blueNear[at.blueNear++] + ordinals.of(plane[0] + plane[1] * value + plane[2] * ordinals.value(green))) | 0;
      } else blue = (blueFar[at.blueFar++] + k + b0) | 0;
    }
    found[o] = ordinals.bits(k);
    found[o + 1] = ordinals.bits(green);
    found[o + 2] = ordinals.bits(blue);
  }
  return found;
}

/** The linear values of a picture, Float32Array [height][width][3]. `known` is what it was told by. */
async function decode(id, width, height, { relations, reference }) {
  const reader = new Reader(await inflate(document.getElementById(`picture-${id}`).textContent));
  const [kind] = reader.take(1);
  const step = kind & stepsKind ? reader.view.getFloat64(1, true) : 0;
  reader.at += step ? 8 : 0;
  const ordinals = ordinalsOf(step);
  const [low, high] = reader.take(2);
  const size = low + 256 * high;
  const colours = readPixels(reader, size, ordinals, relations, { reference: null, colours: null, told: false });
  const total = width * height;
  if (!(kind & paletteKind)) {
    const bits = reference && new Int32Array(reference.buffer);
    const told = Boolean(kind & toldKind);
    return new Float32Array(readPixels(reader, total, ordinals, relations, { reference: bits, colours, told }).buffer);
  }
  const index = reader.take(total);
  const upper = size > 256 ? reader.take(total) : null;
  const found = new Int32Array(3 * total);
  for (let i = 0; i < total; i++) {
    const from = 3 * (index[i] + (upper ? 256 * upper[i] : 0));
    for (let c = 0; c < 3; c++) found[3 * i + c] = colours[from + c];
  }
  return new Float32Array(found.buffer);
}
