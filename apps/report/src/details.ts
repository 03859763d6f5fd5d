// What the report rests on: differences between the scenes, the scene, manifests, notes.
import { dot, h } from './dom';
import type { Report } from './report';
import { cssColourOf } from './status';

/** A table of the values by which the variants' scenes differ from the base scene. */
export function changesTable(report: Report): HTMLElement | null {
  const users = new Map<string, number>();
  for (const { data } of report.variants) {
    for (const pointer of [...data.changes.map((c) => c.pointer), ...(data.dropped ?? [])]) {
      users.set(pointer, (users.get(pointer) ?? 0) + 1);
    }
  }
  // What many variants change comes before what makes a single one special.
  const pointers = [...users.keys()].sort((a, b) => users.get(b)! - users.get(a)!);
  if (pointers.length === 0) return null;
  const row = (variant: Report['variants'][number]) => {
    const values = new Map(variant.data.changes.map((c) => [c.pointer, c.value]));
    const cell = (pointer: string) => {
      if (values.has(pointer)) {
        return h('td', { class: 'text' }, h('code', {}, compact(values.get(pointer))));
      }
      const gone = variant.data.dropped?.includes(pointer);
      return h('td', { class: 'text muted' }, gone ? 'dropped: no such parameter' : 'as the scene');
    };
    return h(
      'tr',
      {},
      h('th', { scope: 'row' }, dot(cssColourOf(variant)), variant.name),
      ...pointers.map(cell),
    );
  };
  return h(
    'section',
    { class: 'changes' },
    h('h2', {}, 'How the variants differ'),
    h(
      'div',
      { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of differences' },
      h(
        'table',
        {},
        h(
          'thead',
          {},
          h(
            'tr',
            {},
            h('th', { scope: 'col' }, 'variant'),
            ...pointers.map((p) => h('th', { scope: 'col' }, h('code', {}, p))),
          ),
        ),
        h('tbody', {}, ...report.variants.map(row)),
      ),
    ),
  );
}

/** JSON on one line, with spaces where a reader wants them. */
function compact(value: unknown): string {
  return JSON.stringify(value, null, 1)
    .replace(/\n\s*/g, ' ')
    .replace(/([[{]) /g, '$1')
    .replace(/ ([\]}])/g, '$1');
}

/** JSON that is written out only when somebody opens it. */
function folded(title: string, value: unknown): HTMLElement {
  const text = h('pre', { tabindex: 0 });
  const element = h('details', {}, h('summary', {}, title), text);
  element.addEventListener('toggle', () => {
    if (element.open && !text.textContent) text.textContent = JSON.stringify(value, null, 2);
  });
  return element;
}

export function details(report: Report): HTMLElement {
  const { scene, notes } = report.data;
  const manifests = report.variants.filter((v) => v.data.manifest);
  return h(
    'section',
    { class: 'details', 'aria-label': 'Scene, manifests, notes' },
    h('h2', {}, 'What this rests on'),
    scene !== null && scene !== undefined && folded('Scene', scene),
    manifests.length > 0 &&
      h(
        'details',
        {},
        h('summary', {}, manifests.length > 1 ? 'Manifests' : 'Manifest'),
        ...manifests.map((v) => folded(v.name, v.data.manifest)),
      ),
    notes.length > 0 && h('ul', { class: 'notes' }, ...notes.map((note) => h('li', {}, note))),
  );
}
