// The quantities that the surface can be coloured by: those that the report brings, and those that
// follow from positions alone.
import type { Scale } from './contract';
import type { Report } from './report';
import type { Variant } from './variant';

export const kPlain = 'plain paper';
export const kDistance = 'distance to reference';
export const kHeight = 'height';

export interface Field {
  name: string;
  unit: string;
  scale: Scale;
  labels: string[];
}

export interface Range {
  low: number;
  high: number;
  /** Whether values lie below or above, in the darkest or lightest colour. */
  clipsLow: boolean;
  clipsHigh: boolean;
}

export class Fields {
  readonly all: Field[] = [];
  private readonly ranges = new Map<string, Range>();
  private readonly r: Float32Array;
  private readonly rReference: Float32Array;

  constructor(private readonly report: Report) {
    this.r = new Float32Array(3 * report.mesh.nodes);
    this.rReference = new Float32Array(3 * report.mesh.nodes);
    const add = (field: Field) => {
      if (!this.find(field.name)) this.all.push(field);
    };
    for (const variant of report.variants) {
      for (const { name, unit, scale, labels } of variant.data.fields) {
        add({ name, unit, scale, labels: labels ?? [] });
      }
    }
    if (report.reference && report.variants.length > 1 && !this.find(kDistance)) {
      this.all.unshift({ name: kDistance, unit: 'm', scale: 'sequential', labels: [] });
    }
    // White at height 0, where the sheet has not moved.
    add({ name: kHeight, unit: 'm', scale: 'diverging', labels: [] });
    add({ name: kPlain, unit: '', scale: 'sequential', labels: [] });
  }

  find(name: string): Field | null {
    return this.all.find((field) => field.name === name) ?? null;
  }

  /** The field to begin with. */
  get first(): string {
    return this.find(kDistance) ? kDistance : kHeight;
  }

  /** Values of a field on a variant at a moment; false if it has none there. */
  values(name: string, variant: Variant, at: number, values: Float32Array): boolean {
    if (!variant.hasShape || name === kPlain) return false;
    if (variant.field(name)) return variant.valuesAt(name, at, values);
    if (name === kHeight) {
      variant.positionsAt(at, this.r);
      for (let k = 0; k < values.length; ++k) values[k] = this.r[3 * k + 2];
      return true;
    }
    const { reference } = this.report;
    if (name !== kDistance || !reference?.hasShape) return false;
    // Both at one moment: a variant that ended is compared with the reference at its end.
    const frame = Math.min(variant.shownFrame(at), reference.shownFrame(at));
    variant.positionsAt(frame, this.r);
    reference.positionsAt(frame, this.rReference);
    for (let k = 0, i = 0; k < values.length; ++k, i += 3) {
      values[k] = Math.hypot(
        this.r[i] - this.rReference[i],
        this.r[i + 1] - this.rReference[i + 1],
        this.r[i + 2] - this.rReference[i + 2],
      );
    }
    return true;
  }

  /** One range for all variants and moments, with or without the few values far from the rest. */
  range(name: string, clip: boolean): Range {
    const key = `${clip}/${name}`;
    let range = this.ranges.get(key);
    if (!range) this.ranges.set(key, (range = this.findRange(name, clip)));
    return range;
  }

  private findRange(name: string, clip: boolean): Range {
    const field = this.find(name);
    if (!field || name === kPlain) return { low: 0, high: 1, clipsLow: false, clipsHigh: false };
    if (field.scale === 'categorical') {
      return { low: 0, high: 255, clipsLow: false, clipsHigh: false };
    }
    const all = this.extremes(name, this.report.variants, 0);
    let { low, high } = all;
    if (clip) {
      const done = this.report.variants.filter((v) => v.isDone);
      ({ low, high } = this.extremes(name, done.length > 0 ? done : this.report.variants, 0.005));
    }
    if (field.scale === 'diverging') {
      high = Math.max(Math.abs(low), Math.abs(high)) || 1;
      low = -high;
    } else if (low >= 0 && low < 0.25 * high) {
      low = 0;
    }
    if (!(high > low)) high = low + (Math.abs(low) || 1);
    const slack = 1e-3 * (high - low);
    return { low, high, clipsLow: all.low < low - slack, clipsHigh: all.high > high + slack };
  }

  /** Extremes over the variants of each one's quantiles `cut` and 1 − `cut`, at a few moments. */
  private extremes(name: string, variants: Variant[], cut: number): { low: number; high: number } {
    let low = Infinity;
    let high = -Infinity;
    for (const variant of variants) {
      const data = variant.field(name);
      if (cut === 0 && data) {
        low = Math.min(low, data.min);
        high = Math.max(high, data.max);
        continue;
      }
      const sample = this.sample(name, variant);
      if (sample.length === 0) continue;
      low = Math.min(low, sample[Math.floor(cut * (sample.length - 1))]);
      high = Math.max(high, sample[Math.ceil((1 - cut) * (sample.length - 1))]);
    }
    return high >= low ? { low, high } : { low: 0, high: 1 };
  }

  /** Some of the values of a field, sorted: at four moments, at up to 4000 nodes. */
  private sample(name: string, variant: Variant): Float32Array {
    const values = new Float32Array(this.report.mesh.nodes);
    const stride = Math.ceil(values.length / 4000);
    const last = variant.data.frames - 1;
    const moments = new Set([0.25, 0.5, 0.75, 1].map((t) => Math.round(t * last)));
    const sample: number[] = [];
    for (const at of moments) {
      if (!this.values(name, variant, at, values)) continue;
      for (let k = 0; k < values.length; k += stride) {
        if (!Number.isNaN(values[k])) sample.push(values[k]);
      }
    }
    return Float32Array.from(sample).sort();
  }
}
