// The one colour scale of all tiles.
import { categoryColour, gradientStops } from './colormap';
import { h } from './dom';
import { kPlain, type Fields } from './fields';
import { formatNumber, roundTicks, withUnit } from './format';
import type { ViewStore } from './view';

export function legend(fields: Fields, view: ViewStore): HTMLElement {
  const element = h('div', { class: 'legend', role: 'img' });
  const update = () => {
    const { field, clip } = view.now;
    const found = fields.find(field);
    element.replaceChildren();
    if (!found || found.name === kPlain) {
      element.setAttribute('aria-label', 'plain paper, no colours');
      return;
    }
    const title = withUnit(found.name, found.unit);
    if (found.scale === 'categorical') {
      element.append(h('span', { class: 'legend-title' }, title), categories(found.labels));
      element.setAttribute('aria-label', `Colours: ${title}: ${found.labels.join(', ')}`);
      return;
    }
    const range = fields.range(field, clip);
    const { low, high } = range;
    element.append(
      h('span', { class: 'legend-title' }, title),
      h(
        'div',
        { class: 'legend-scale' },
        h('div', {
          class: `legend-bar${range.clipsLow ? ' low' : ''}${range.clipsHigh ? ' high' : ''}`,
          style: `background: linear-gradient(to right, ${gradientStops(found.scale).join(', ')})`,
        }),
        h('div', { class: 'legend-ticks' }, ...ticks(low, high)),
      ),
    );
    const ends = [low, high].map((x) => formatNumber(x));
    element.setAttribute('aria-label', `Colours: ${title} from ${ends[0]} to ${ends[1]}`);
  };
  view.on(['field', 'clip'], update);
  update();
  return element;
}

function ticks(low: number, high: number): HTMLElement[] {
  return roundTicks(low, high, 4).map((x) => {
    const at = (100 * (x - low)) / (high - low);
    return h('span', { style: `left: ${at}%` }, formatNumber(x));
  });
}

function categories(labels: string[]): HTMLElement {
  return h(
    'ul',
    { class: 'legend-labels' },
    ...labels.map((label, i) =>
      h('li', {}, h('span', { class: 'swatch', style: `background: ${categoryColour(i)}` }), label),
    ),
  );
}
