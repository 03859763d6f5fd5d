// Colour maps of fields. The sequential one starts at the white of paper, so that a sheet on which
// the quantity vanishes looks like a sheet, and ends dark; its lightness falls evenly.
import { css, fromCss, fromOklab, toOklab, type Rgb } from './colour';
import type { Scale } from './contract';

export const kMapSize = 256;

const kSequential = ['#f6f3ea', '#f6d27a', '#f08a3c', '#cf3f4f', '#84206b', '#2f1150'];
const kDiverging = ['#0b3c73', '#2f7fc1', '#9cc8e2', '#f4f2ee', '#f0b48c', '#cf5a3a', '#7d1425'];
// Okabe and Ito's colours, which the colour-blind tell apart, after paper white for "usual".
const kCategories = [
  '#ece7da', '#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#f0e442',
];

/** Points at equal steps of OKLab distance along the polygon through `stops`. */
function evenMap(stops: string[]): Rgb[] {
  const corners = stops.map((stop) => toOklab(fromCss(stop)));
  const lengths = [0];
  for (let i = 1; i < corners.length; ++i) {
    const step = corners[i].map((x, c) => x - corners[i - 1][c]);
    lengths.push(lengths[i - 1] + Math.hypot(...step));
  }
  const total = lengths[lengths.length - 1];
  let part = 1;
  return Array.from({ length: kMapSize }, (_, i) => {
    const at = (i / (kMapSize - 1)) * total;
    while (part < lengths.length - 1 && at > lengths[part]) ++part;
    const t = (at - lengths[part - 1]) / (lengths[part] - lengths[part - 1]);
    const [L, a, b] = corners[part].map((x, c) => corners[part - 1][c] * (1 - t) + x * t);
    return fromOklab(L, a, b);
  });
}

const kMaps = { sequential: evenMap(kSequential), diverging: evenMap(kDiverging) };

export function categoryColour(label: number): string {
  return kCategories[label % kCategories.length];
}

/** kMapSize colours; of a categorical scale, entry i is the colour of label i. */
export function colourTable(scale: Scale): Rgb[] {
  if (scale !== 'categorical') return kMaps[scale];
  return Array.from({ length: kMapSize }, (_, i) => fromCss(categoryColour(i)));
}

/** The map as stops of a CSS or canvas gradient. */
export function gradientStops(scale: Scale, count = 24): string[] {
  const table = colourTable(scale);
  return Array.from({ length: count }, (_, i) =>
    css(table[Math.round((i / (count - 1)) * (kMapSize - 1))]),
  );
}
