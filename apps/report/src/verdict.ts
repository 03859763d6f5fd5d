// The verdict: sentences on top of the page, a table that can be sorted below.
import { dot, h } from './dom';
import { formatNumber, withUnit } from './format';
import type { Report } from './report';
import { badge, cssColourOf } from './status';
import type { Variant } from './variant';

interface Column {
  title: string;
  better: 'lower' | 'higher' | null;
  value: (variant: Variant) => number | string | null;
}

const kCosts: Record<string, string> = {
  ms_per_step: 'cost [ms/step]',
  peak_memory_MB: 'peak memory [MB]',
  iterations: 'iterations',
};

export function header(report: Report): HTMLElement {
  const { title, created, program, kind, verdict, variants } = report.data;
  const [first, ...rest] = verdict?.sentences ?? [];
  const count = variants.length;
  const about = [kind === 'run' ? 'run' : `${count} variants`, created, program].filter(Boolean);
  return h(
    'header',
    { class: 'head' },
    h('p', { class: 'about' }, about.join(' · ')),
    h('h1', {}, title),
    first && h('p', { class: 'headline' }, first),
    rest.length > 0 && h('p', { class: 'sentences' }, rest.join(' ')),
  );
}

function columns(report: Report): Column[] {
  const { verdict, variants } = report.data;
  const all: Column[] = (verdict?.columns ?? []).map((c, i) => {
    const values = new Map(verdict?.rows.map((row) => [row.variant, row.values[i]]));
    return {
      title: withUnit(c.name, c.unit),
      better: c.better,
      value: (variant) => values.get(variant.name) ?? null,
    };
  });
  const known = new Set(verdict?.columns.map((c) => c.name));
  for (const [key, title] of Object.entries(kCosts)) {
    if (known.has(key) || !variants.some((v) => typeof v.cost?.[key] === 'number')) continue;
    all.push({ title, better: 'lower', value: (v) => v.data.cost?.[key] ?? null });
  }
  return all;
}

/** The best value of a column, among variants that ran to their end and are not the reference. */
function best(report: Report, column: Column): number | null {
  if (!column.better) return null;
  const values = report.variants
    .filter((v) => v.isDone && !v.isReference)
    .map((v) => column.value(v))
    .filter((x): x is number => typeof x === 'number');
  if (values.length < 2 || values.every((x) => x === values[0])) return null;
  return column.better === 'lower' ? Math.min(...values) : Math.max(...values);
}

export function verdictTable(report: Report): HTMLElement | null {
  const all = columns(report);
  const reasons = report.variants.filter((v) => !v.isDone && v.data.reason);
  if (all.length === 0 && reasons.length === 0) return null;
  const bests = all.map((column) => best(report, column));
  const body = h('tbody');
  const row = (variant: Variant) => {
    const { tone, text, title } = badge(report, variant, report.lastFrame);
    return h(
      'tr',
      { 'data-variant': variant.name },
      h('th', { scope: 'row' }, dot(cssColourOf(variant)), variant.name),
      h('td', { class: 'text' }, h('span', { class: 'badge', 'data-tone': tone, title }, text)),
      ...all.map((column, i) => cell(column.value(variant), bests[i])),
    );
  };
  const order = (compare: ((a: Variant, b: Variant) => number) | null) => {
    const sorted = compare ? [...report.variants].sort(compare) : report.variants;
    body.replaceChildren(...sorted.map(row));
  };
  order(null);
  return h(
    'section',
    { class: 'verdict', 'aria-label': 'Verdict' },
    h('h2', {}, report.data.kind === 'run' ? 'How it went' : 'Verdict'),
    h(
      'div',
      { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of the verdict' },
      h('table', {}, h('thead', {}, heads(report, all, order)), body),
    ),
    reasons.length > 0 &&
      h(
        'ul',
        { class: 'reasons' },
        ...reasons.map((v) => {
          const text = ` ${v.data.status}: ${v.data.reason}`;
          return h('li', {}, dot(cssColourOf(v)), h('b', {}, v.name), text);
        }),
      ),
  );
}

function cell(value: number | string | null, best: number | null): HTMLElement {
  if (typeof value === 'string') return h('td', { class: 'text' }, value);
  const isBest = value !== null && value === best;
  const title = isBest ? 'the best of those that came to the end' : null;
  return h('td', { class: isBest ? 'best' : '', title }, formatNumber(value, 4));
}

type Order = (compare: ((a: Variant, b: Variant) => number) | null) => void;

function heads(report: Report, all: Column[], order: Order): HTMLElement {
  const state: Column = {
    title: 'state',
    better: null,
    value: (v) => badge(report, v, report.lastFrame).text,
  };
  const name: Column = { title: 'variant', better: null, value: (v) => v.name };
  const cells: HTMLElement[] = [];
  for (const column of [name, state, ...all]) {
    const head = h('th', { scope: 'col' });
    const sort = () => {
      const ascending = head.getAttribute('aria-sort') !== 'ascending';
      for (const other of cells) other.removeAttribute('aria-sort');
      head.setAttribute('aria-sort', ascending ? 'ascending' : 'descending');
      order((a, b) => compare(column.value(a), column.value(b), ascending));
    };
    const hint = column.better ? `${column.better} is better` : null;
    head.append(h('button', { type: 'button', title: hint, on: { click: sort } }, column.title));
    cells.push(head);
  }
  return h('tr', {}, ...cells);
}

/** Orders values; those that do not exist come last in either direction. */
function compare(a: number | string | null, b: number | string | null, ascending: boolean): number {
  if (a === null || b === null) return Number(a === null) - Number(b === null);
  const order =
    typeof a === 'number' && typeof b === 'number'
      ? a - b
      : String(a).localeCompare(String(b), 'en', { numeric: true });
  return ascending ? order : -order;
}
