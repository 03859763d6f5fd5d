// Pixels of PNG files as Chromium writes them: 8 bits a channel, RGB or RGBA, not interlaced.
import { inflateSync } from 'node:zlib';

export function readPng(file) {
  const width = file.readUInt32BE(16);
  const height = file.readUInt32BE(20);
  const channels = { 2: 3, 6: 4 }[file[25]];
  if (file[24] !== 8 || !channels) throw new Error('not a PNG that this reads');
  const parts = [];
  for (let at = 8; at < file.length; ) {
    const length = file.readUInt32BE(at);
    const end = at + 8 + length;
    if (file.toString('latin1', at + 4, at + 8) === 'IDAT') parts.push(file.subarray(at + 8, end));
    at = end + 4;
  }
  const pixels = unfilter(inflateSync(Buffer.concat(parts)), width * channels, height, channels);
  const colours = new Set();
  for (let i = 0; i < pixels.length; i += channels) {
    colours.add((pixels[i] << 16) | (pixels[i + 1] << 8) | pixels[i + 2]);
  }
  /** The share of pixels darker than `limit` (in green) in a rectangle. */
  const share = (x, y, w, h, limit) => {
    let dark = 0;
    for (let j = y; j < y + h; ++j) {
      for (let i = x; i < x + w; ++i) {
        if (pixels[(j * width + i) * channels + 1] < limit) ++dark;
      }
    }
    return dark / (w * h);
  };
  return { width, height, channels, pixels, colours: colours.size, share };
}

/** The share of pixels that differ visibly between two pictures of one size. */
export function different(a, b) {
  if (a.width !== b.width || a.height !== b.height) return 1;
  let count = 0;
  for (let i = 0; i < a.pixels.length; i += a.channels) {
    const far = [0, 1, 2].some((c) => Math.abs(a.pixels[i + c] - b.pixels[i + c]) > 12);
    if (far) ++count;
  }
  return count / (a.width * a.height);
}

function unfilter(raw, stride, height, bytes) {
  const out = Buffer.alloc(stride * height);
  for (let y = 0; y < height; ++y) {
    const filter = raw[y * (stride + 1)];
    for (let x = 0; x < stride; ++x) {
      const left = x >= bytes ? out[y * stride + x - bytes] : 0;
      const up = y > 0 ? out[(y - 1) * stride + x] : 0;
      const corner = x >= bytes && y > 0 ? out[(y - 1) * stride + x - bytes] : 0;
      const guess = [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
      out[y * stride + x] = raw[y * (stride + 1) + 1 + x] + guess;
    }
  }
  return out;
}

function paeth(a, b, c) {
  const [pa, pb, pc] = [Math.abs(b - c), Math.abs(a - c), Math.abs(a + b - 2 * c)];
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}
