// What became of a variant, in the few words that its badge has room for.
import { variantColour } from './colour';
import type { Report } from './report';
import { formatQuantity } from './format';
import { themeColour } from './theme';
import type { Variant } from './variant';

export type Tone = 'reference' | 'good' | 'bad' | 'warning' | 'neutral';

export interface Badge {
  tone: Tone;
  text: string;
  /** One word, for small tiles. */
  short: string;
  /** The whole story, for a tooltip. */
  title: string;
}

/** The colour of a variant for elements: the reference's is that of the text. */
export function cssColourOf(variant: Variant): string {
  return variant.isReference ? 'var(--ink)' : variantColour(variant.index);
}

/** The same as a value, for canvases; it goes with the theme. */
export function colourOf(variant: Variant): string {
  return variant.isReference ? themeColour('--ink') : variantColour(variant.index);
}

/** The badge of a variant at a moment `at`; of the whole run if `at` is the last frame. */
export function badge(report: Report, variant: Variant, at: number): Badge {
  const { status, reason, parts } = variant.data;
  if (status !== 'done') {
    const end = report.data.frames.times[variant.data.frames - 1];
    const when = end === undefined ? '' : ` after ${formatQuantity(end, 's')}`;
    return { tone: 'bad', text: `${status}${when}`, short: status, title: reason || status };
  }
  if (variant.isReference) {
    const text = 'reference';
    return { tone: 'reference', text, short: text, title: 'the others are measured against this' };
  }
  if (parts) {
    const when = formatQuantity(parts.time, 's');
    const where = parts.where.map((a) => formatQuantity(a, '')).join(', ');
    const tolerance = report.data.tolerance;
    const least = tolerance ? formatQuantity(tolerance.value, tolerance.unit) : '';
    const limit = least ? ` by more than ${least}` : '';
    const title =
      `leaves ${report.data.reference}${limit} first at ${when} (step ${parts.step}), ` +
      `node ${parts.node} at (${where})`;
    const gone = report.time(at) >= parts.time * (1 - 1e-9);
    return gone
      ? { tone: 'bad', text: `off since ${when}`, short: 'off', title }
      : { tone: 'warning', text: `leaves at ${when}`, short: 'leaves', title };
  }
  if (variant.data.not_measured) {
    const title = variant.data.not_measured;
    return { tone: 'neutral', text: 'not measured', short: 'unmeasured', title };
  }
  if (report.reference) {
    const name = report.data.reference;
    const title = `stays with ${name} to the end`;
    return { tone: 'good', text: `follows ${name}`, short: 'follows', title };
  }
  return { tone: 'neutral', text: 'done', short: 'done', title: 'ran to its end' };
}
