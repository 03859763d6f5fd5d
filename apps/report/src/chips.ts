// The variants' names in their colours: key to the plots, and switches.
import { dot, h } from './dom';
import type { Report } from './report';
import { badge, cssColourOf } from './status';
import type { ViewStore } from './view';

export function chips(report: Report, view: ViewStore): HTMLElement | null {
  if (report.variants.length < 2) return null;
  const buttons = report.variants.map((variant) => {
    const flip = () => {
      const hidden = new Set(view.now.hidden);
      if (!hidden.delete(variant.name)) hidden.add(variant.name);
      view.set({ hidden, isolated: null });
    };
    const { tone } = badge(report, variant, report.lastFrame);
    return h(
      'button',
      { type: 'button', class: 'chip', 'data-tone': tone, on: { click: flip } },
      dot(cssColourOf(variant)),
      variant.name,
    );
  });
  const all = h(
    'button',
    { type: 'button', class: 'link', on: { click: () => showAll(view) } },
    'show all',
  );
  const update = () => {
    const { hidden, isolated } = view.now;
    report.variants.forEach(({ name }, i) => {
      const shown = isolated === null ? !hidden.has(name) : name === isolated;
      buttons[i].setAttribute('aria-pressed', String(shown));
      buttons[i].title = hidden.has(name) ? `Show ${name}` : `Hide ${name}`;
    });
    all.hidden = hidden.size === 0 && isolated === null;
  };
  view.on(['hidden', 'isolated'], update);
  update();
  const role = { role: 'group', 'aria-label': 'Shown variants' };
  return h('div', { class: 'chips', ...role }, ...buttons, all);
}

function showAll(view: ViewStore): void {
  view.set({ hidden: new Set(), isolated: null });
}
