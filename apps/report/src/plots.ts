// Probes over time: one plot a quantity, one line a variant, the slider's moment as a line in all.
import { h } from './dom';
import { Plot, type Quantity } from './plot';
import type { Report } from './report';
import { onThemeChange } from './theme';
import type { ViewStore } from './view';

/** Every probed quantity; the first two columns of a table are step and time. */
function quantities(report: Report): Quantity[] {
  const found = new Map<string, Quantity>();
  for (const { data } of report.variants) {
    data.probes.columns.forEach(({ name, unit }, i) => {
      // A probe may have nothing to say: an energy without normals has no error of normals.
      const speaks = i >= 2 && data.probes.rows.some((row) => typeof row[i] === 'number');
      if (speaks && !found.has(name)) found.set(name, { name, unit });
    });
  }
  return [...found.values()];
}

export function plots(report: Report, view: ViewStore): HTMLElement | null {
  const all = quantities(report).map((quantity) => new Plot(report, view, quantity));
  if (all.length === 0) return null;
  const byElement = new Map<Element, Plot>(all.map((plot) => [plot.element, plot]));
  // Dozens of plots with dozens of lines each: drawn when they come into sight.
  const sight = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) {
        if (entry.isIntersecting) byElement.get(entry.target)?.draw();
      }
    },
    { rootMargin: '300px' },
  );
  const size = new ResizeObserver((entries) => {
    for (const entry of entries) byElement.get(entry.target)?.resize();
  });
  for (const plot of all) {
    sight.observe(plot.element);
    size.observe(plot.element);
  }
  view.on(['at'], () => all.forEach((plot) => plot.moveCursor()));
  view.on(['hidden', 'isolated'], () => all.forEach((plot) => plot.showChosen()));
  onThemeChange(() => all.forEach((plot) => plot.redraw()));
  addEventListener('beforeprint', () => all.forEach((plot) => plot.draw()));
  return h(
    'section',
    { class: 'plots', 'aria-label': 'Probes' },
    h('h2', {}, 'Measured while running'),
    h('div', { class: 'plot-grid' }, ...all.map((plot) => plot.element)),
  );
}
