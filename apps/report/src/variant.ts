// One run of the report: its shape and fields at a moment.
import { kLevels, kMissing, LevelFrames } from './blocks';
import type { FieldData, VariantData } from './contract';

export class Variant {
  private readonly positions: LevelFrames;
  private readonly fields = new Map<string, { data: FieldData; levels: LevelFrames }>();

  constructor(
    readonly data: VariantData,
    /** Place in the report; colours go by it. */
    readonly index: number,
    readonly isReference: boolean,
    private readonly nodes: number,
  ) {
    this.positions = new LevelFrames(data.positions.data, 3 * nodes);
    for (const field of data.fields) {
      this.fields.set(field.name, { data: field, levels: new LevelFrames(field.data, nodes) });
    }
  }

  get name(): string {
    return this.data.name;
  }

  /** Whether it came to its end as a scene should. */
  get isDone(): boolean {
    return this.data.status === 'done';
  }

  get hasShape(): boolean {
    return this.data.frames > 0;
  }

  /** The frame that is shown at frame `at` of the report: the last one, once it has ended. */
  shownFrame(at: number): number {
    return Math.min(at, this.data.frames - 1);
  }

  field(name: string): FieldData | null {
    return this.fields.get(name)?.data ?? null;
  }

  /** Positions [m] at frame `at`, which may lie between two frames; nodes × 3 into `r`. */
  positionsAt(at: number, r: Float32Array): void {
    const { min, max } = this.data.positions;
    const frame = this.shownFrame(at);
    const before = Math.floor(frame);
    const t = frame - before;
    const a = this.positions.frame(before);
    const b = t > 0 ? this.positions.frame(before + 1) : a;
    for (let c = 0; c < 3; ++c) {
      const scale = (max[c] - min[c]) / kLevels;
      for (let k = c; k < r.length; k += 3) {
        r[k] = min[c] + scale * (a[k] + t * (b[k] - a[k]));
      }
    }
  }

  /** Values of a field at the frame nearest to `at`, NaN where it has none; false without field. */
  valuesAt(name: string, at: number, values: Float32Array): boolean {
    const field = this.fields.get(name);
    if (!field || !this.hasShape) return false;
    const { min, max, scale } = field.data;
    const levels = field.levels.frame(Math.round(this.shownFrame(at)));
    const factor = scale === 'categorical' ? 1 : (max - min) / kLevels;
    const offset = scale === 'categorical' ? 0 : min;
    for (let k = 0; k < this.nodes; ++k) {
      values[k] = levels[k] === kMissing ? NaN : offset + factor * levels[k];
    }
    return true;
  }
}
