// Colours, made in OKLab so that equal steps look equal. Channels are sRGB, 0 … 1.

export type Rgb = [number, number, number];

function encode(x: number): number {
  const clamped = Math.min(Math.max(x, 0), 1);
  return clamped <= 0.0031308 ? 12.92 * clamped : 1.055 * clamped ** (1 / 2.4) - 0.055;
}

function decode(x: number): number {
  return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
}

export function fromOklab(L: number, a: number, b: number): Rgb {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    encode(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    encode(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    encode(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

export function toOklab(rgb: Rgb): Rgb {
  const [r, g, b] = rgb.map(decode);
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}

export function fromOklch(L: number, chroma: number, degrees: number): Rgb {
  const hue = (degrees * Math.PI) / 180;
  return fromOklab(L, chroma * Math.cos(hue), chroma * Math.sin(hue));
}

export function css(rgb: Rgb): string {
  return '#' + rgb.map((x) => Math.round(x * 255).toString(16).padStart(2, '0')).join('');
}

export function fromCss(hex: string): Rgb {
  return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255) as Rgb;
}

// Hues that are told apart; red is left out, because red says "failed" on this page.
const kHues = [255, 65, 150, 330, 200, 100, 295, 175];

/** The colour of the variant with this index; different for dozens of them. */
export function variantColour(index: number): string {
  const round = Math.floor(index / kHues.length);
  const lightness = [0.63, 0.5, 0.76][round % 3];
  const hue = kHues[index % kHues.length] + 11 * round;
  return css(fromOklch(lightness, 0.15 - 0.025 * (round % 2), hue));
}
