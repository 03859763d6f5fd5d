// The whole report, ready to be shown: mesh, variants, recorded moments.
import type { ReportData } from './contract';
import { Mesh } from './mesh';
import { Variant } from './variant';

interface Box {
  min: number[];
  max: number[];
}

export class Report {
  readonly mesh: Mesh;
  /** The reference first, then as in the scene. */
  readonly variants: Variant[];
  readonly reference: Variant | null;

  constructor(readonly data: ReportData) {
    this.mesh = new Mesh(data.mesh);
    this.variants = data.variants.map(
      (v, i) => new Variant(v, i, v.name === data.reference, data.mesh.nodes),
    );
    this.variants.sort((a, b) => Number(b.isReference) - Number(a.isReference));
    this.reference = this.variants.find((v) => v.isReference) ?? null;
  }

  get frameCount(): number {
    return this.data.frames.times.length;
  }

  get lastFrame(): number {
    return Math.max(this.frameCount - 1, 0);
  }

  variant(name: string): Variant | null {
    return this.variants.find((v) => v.name === name) ?? null;
  }

  /** Time [s] of a frame, or of a moment between two. */
  time(at: number): number {
    const { times } = this.data.frames;
    const i = Math.min(Math.floor(at), this.lastFrame);
    const next = Math.min(i + 1, this.lastFrame);
    return (times[i] ?? 0) + (at - i) * ((times[next] ?? 0) - (times[i] ?? 0));
  }

  nearestFrame(time: number): number {
    let best = 0;
    this.data.frames.times.forEach((t, i) => {
      if (Math.abs(t - time) < Math.abs(this.data.frames.times[best] - time)) best = i;
    });
    return best;
  }

  /** Points that the camera should show: some of the trustworthy variants', at three moments. */
  outline(): number[][] {
    const { min, max } = this.extent();
    const shown = this.variants.filter((v) => v.hasShape);
    const done = shown.filter((v) => v.isDone);
    const r = new Float32Array(3 * this.mesh.nodes);
    const stride = 3 * Math.ceil(this.mesh.nodes / 1500);
    const points: number[][] = [];
    // Sixty variants need not all be asked: the box keeps those in the picture that are.
    for (const variant of (done.length > 0 ? done : shown).slice(0, 12)) {
      for (const part of [0, 0.5, 1]) {
        variant.positionsAt(Math.round(part * (variant.data.frames - 1)), r);
        for (let k = 0; k < r.length; k += stride) {
          points.push([0, 1, 2].map((c) => Math.min(Math.max(r[k + c], min[c]), max[c])));
        }
      }
    }
    return points;
  }

  /** The box in which the trustworthy variants move. */
  private extent(): Box {
    const shown = this.variants.filter((v) => v.hasShape);
    const done = shown.filter((v) => v.isDone);
    const boxes = (done.length > 0 ? done : shown).map((v) => v.data.positions);
    if (boxes.length === 0) return { min: [0, 0, 0], max: [1, 1, 1] };
    const core = this.reference?.isDone ? this.reference.data.positions : boxes[0];
    const reach = Math.max(...core.max.map((x, c) => x - core.min[c]));
    // A variant that flies away must not make the others small.
    return {
      min: [0, 1, 2].map((c) =>
        Math.max(Math.min(...boxes.map((b) => b.min[c])), core.min[c] - reach / 2),
      ),
      max: [0, 1, 2].map((c) =>
        Math.min(Math.max(...boxes.map((b) => b.max[c])), core.max[c] + reach / 2),
      ),
    };
  }

  /** Largest distance [m] of a node to the reference's at r, r_reference: nodes × 3. */
  static largestDistance(r: Float32Array, reference: Float32Array): number {
    let largest = 0;
    for (let k = 0; k < r.length; k += 3) {
      const d =
        (r[k] - reference[k]) ** 2 +
        (r[k + 1] - reference[k + 1]) ** 2 +
        (r[k + 2] - reference[k + 2]) ** 2;
      if (d > largest) largest = d;
    }
    return Math.sqrt(largest);
  }
}
