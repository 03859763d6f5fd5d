// Numbers as readers see them.

/** `digits` significant digits, a real minus sign, powers of ten where zeros would be counted. */
export function formatNumber(x: number | null | undefined, digits = 3): string {
  if (x === null || x === undefined || Number.isNaN(x)) return '–';
  if (!Number.isFinite(x)) return x > 0 ? '∞' : '−∞';
  if (x === 0) return '0';
  const magnitude = Math.abs(x);
  let text: string;
  if (magnitude < 1e-3 || magnitude >= 1e5) {
    text = x.toExponential(digits - 1).replace(/\.?0+e/, 'e').replace('e+', 'e');
  } else {
    text = x.toPrecision(digits);
    if (text.includes('e')) text = String(Math.round(x));
    if (text.includes('.')) text = text.replace(/\.?0+$/, '');
  }
  return text.replaceAll('-', '−');
}

export function formatQuantity(x: number | null | undefined, unit: string, digits = 3): string {
  const text = formatNumber(x, digits);
  return hasUnit(unit) && text !== '–' ? `${text} ${unit}` : text;
}

/** A length given in metres, in the unit that suits it. */
export function formatLength(metres: number): string {
  const magnitude = Math.abs(metres);
  if (magnitude === 0) return '0 mm';
  if (magnitude >= 1) return formatQuantity(metres, 'm');
  if (magnitude >= 1e-4) return formatQuantity(metres * 1e3, 'mm', magnitude < 0.01 ? 2 : 3);
  if (magnitude >= 1e-7) return formatQuantity(metres * 1e6, 'µm', 2);
  return '< 0.1 µm';
}

export function withUnit(name: string, unit: string): string {
  return hasUnit(unit) ? `${name} [${unit}]` : name;
}

/** Ratios have the unit 1 or none. */
function hasUnit(unit: string): boolean {
  return unit !== '' && unit !== '1';
}

/** About `count` round numbers from `low` to `high`. */
export function roundTicks(low: number, high: number, count: number): number[] {
  const span = high - low;
  if (!(span > 0) || !Number.isFinite(span)) return [low];
  const raw = span / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((m) => m * power).find((s) => s >= raw * 0.999)!;
  const ticks: number[] = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; ++i) {
    ticks.push(i * step);
  }
  return ticks;
}
