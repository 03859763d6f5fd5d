// What surrounds the picture of one variant: name, badge, figures, buttons.
import { dot, h, icon } from './dom';
import { formatLength, formatNumber } from './format';
import { kCreaseDegrees } from './mesh';
import type { Report } from './report';
import { badge, cssColourOf } from './status';
import type { Variant } from './variant';
import type { ViewStore } from './view';

export interface Figures {
  /** Share of edges that are creased, or null without shape. */
  creased: number | null;
  /** Largest distance to the reference [m], or null. */
  distance: number | null;
}

export class Tile {
  readonly element: HTMLElement;
  /** Names the moment that the figures are of. */
  shownMoment = '';
  private readonly badge = h('span', { class: 'badge' });
  private readonly figures = h('span', { class: 'figures' });
  private readonly enlarge: HTMLButtonElement;

  constructor(
    private readonly report: Report,
    readonly variant: Variant,
    view: ViewStore,
  ) {
    const { name } = variant;
    this.enlarge = button('enlarge', `Enlarge ${name}`, () => {
      view.set({ isolated: view.now.isolated === name ? null : name });
    });
    const hide = button('close', `Hide ${name}`, () => {
      view.set({ hidden: new Set([...view.now.hidden, name]), isolated: null });
    });
    const reason = variant.isDone ? null : h('p', { class: 'reason' }, variant.data.reason);
    this.element = h(
      'article',
      { class: 'tile', 'aria-label': name, 'data-variant': name },
      h('header', {}, dot(cssColourOf(variant)), h('h3', { title: name }, name)),
      h('div', { class: 'tools' }, this.enlarge, report.variants.length > 1 && hide),
      reason,
      h('footer', {}, this.badge, this.figures),
    );
  }

  update(at: number, figures: Figures, isolated: boolean): void {
    const { tone, text, short, title } = badge(this.report, this.variant, at);
    this.badge.replaceChildren(
      h('span', { class: 'long' }, text),
      h('span', { class: 'short' }, short),
    );
    this.badge.title = title;
    this.badge.dataset.tone = tone;
    this.element.dataset.tone = tone;
    this.element.classList.toggle('isolated', isolated);
    this.enlarge.setAttribute('aria-pressed', String(isolated));
    this.showFigures(figures);
  }

  private showFigures({ creased, distance }: Figures): void {
    const parts: HTMLElement[] = [];
    if (distance !== null && !this.variant.isReference) {
      const title = `largest distance of a node to the same node of ${this.report.data.reference}`;
      parts.push(h('span', { title }, h('b', {}, formatLength(distance)), ' off'));
    }
    if (creased !== null) {
      const title = `share of the mesh's edges that bend by more than ${kCreaseDegrees}°`;
      const share = `${formatNumber(100 * creased, 2)} %`;
      parts.push(h('span', { title }, h('b', {}, share), ' creased'));
    }
    this.figures.replaceChildren(...parts);
  }
}

function button(name: 'enlarge' | 'close', label: string, act: () => void): HTMLButtonElement {
  const click = (event: Event) => {
    event.stopPropagation();
    act();
  };
  // The stage captures pointers for the camera; a button keeps its own.
  const keep = (event: Event) => event.stopPropagation();
  const element = h('button', { type: 'button', title: label, 'aria-label': label });
  element.append(icon(name));
  element.addEventListener('click', click);
  element.addEventListener('pointerdown', keep);
  element.addEventListener('pointerup', keep);
  return element;
}
