// What to colour by, from where to look, what else to draw.
import { h } from './dom';
import type { Fields } from './fields';
import { withUnit } from './format';
import { legend } from './legend';
import type { Report } from './report';
import type { Stage } from './stage';
import type { NamedCamera, View, ViewStore } from './view';

export function toolbar(
  report: Report,
  fields: Fields,
  view: ViewStore,
  stage: Stage,
  saveSheet: () => void,
): HTMLElement {
  return h(
    'section',
    { class: 'toolbar', 'aria-label': 'View' },
    fieldSelect(fields, view),
    legend(fields, view),
    h('div', { class: 'group', role: 'group', 'aria-label': 'Camera' }, ...views(stage)),
    h(
      'div',
      { class: 'group plain', role: 'group', 'aria-label': 'Options' },
      toggle(view, 'lines', 'grid lines'),
      report.reference && report.variants.length > 1 && toggle(view, 'ghost', 'reference ghost'),
      toggle(view, 'clip', 'clip outliers'),
      exaggeration(view),
    ),
    h(
      'button',
      {
        type: 'button',
        class: 'save',
        title: 'Variants × five moments as one PNG, for papers',
        on: { click: saveSheet },
      },
      'Save PNG',
    ),
  );
}

function fieldSelect(fields: Fields, view: ViewStore): HTMLElement {
  const select = h(
    'select',
    { id: 'field' },
    ...fields.all.map((f) => h('option', { value: f.name }, withUnit(f.name, f.unit))),
  );
  const update = () => (select.value = view.now.field);
  select.addEventListener('change', () => view.set({ field: select.value }));
  view.on(['field'], update);
  update();
  return h('div', { class: 'field' }, h('label', { for: 'field' }, 'Colour'), select);
}

function views(stage: Stage): HTMLElement[] {
  const names: NamedCamera[] = ['fit', 'top', 'front', 'side'];
  return names.map((name) =>
    h('button', { type: 'button', on: { click: () => stage.look(name) } }, name),
  );
}

function toggle(view: ViewStore, key: 'lines' | 'ghost' | 'clip', text: string): HTMLElement {
  const box = h('input', { type: 'checkbox' });
  const update = () => (box.checked = view.now[key]);
  box.addEventListener('change', () => view.set({ [key]: box.checked } as Partial<View>));
  view.on([key], update);
  update();
  return h('label', { class: 'toggle' }, box, text);
}

function exaggeration(view: ViewStore): HTMLElement {
  const select = h(
    'select',
    { 'aria-label': 'Exaggeration of heights' },
    ...[1, 2, 3, 5, 10].map((x) => h('option', { value: x }, `${x}×`)),
  );
  const update = () => (select.value = String(view.now.exaggeration));
  select.addEventListener('change', () => view.set({ exaggeration: Number(select.value) }));
  view.on(['exaggeration'], update);
  update();
  return h('label', { class: 'toggle' }, 'height', select);
}
