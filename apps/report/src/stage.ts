// The variants side by side: one canvas, a tile for each, one camera, one moment.
import { SharedCamera } from './camera';
import { h } from './dom';
import type { Fields } from './fields';
import { chooseGrid } from './layout';
import { Renderer, type Rectangle } from './renderer';
import { Report } from './report';
import { onThemeChange } from './theme';
import { Tile } from './tile';
import { Tooltip } from './tooltip';
import type { Variant } from './variant';
import type { NamedCamera, ViewStore } from './view';

/** The bar of time below the stage [px]. */
const kBelow = 74;

export class Stage {
  readonly element: HTMLElement;
  readonly camera: SharedCamera;
  /** Resolves when the first picture has been drawn. */
  readonly drawn: Promise<void>;
  readonly renderer: Renderer;
  private readonly canvas = h('canvas', { 'aria-hidden': 'true' });
  private readonly grid = h('div', { class: 'tiles' });
  private readonly pager = h('nav', { class: 'pager', 'aria-label': 'Pages of variants' });
  private readonly tiles: Tile[];
  private readonly tooltip: Tooltip;
  private readonly rScratch: Float32Array;
  private outline: number[][] | null = null;
  private marked: number | null = null;
  private capacity = 1;
  private pending = false;
  private reportDrawn: () => void = () => {};

  constructor(
    private readonly report: Report,
    fields: Fields,
    private readonly view: ViewStore,
  ) {
    this.tiles = report.variants.map((variant) => new Tile(report, variant, view));
    this.grid.append(...this.tiles.map((tile) => tile.element));
    const surface = h('div', { class: 'surface' }, this.canvas, this.grid);
    this.element = h('section', { class: 'stage', 'aria-label': 'Variants' }, surface, this.pager);
    this.rScratch = new Float32Array(3 * report.mesh.nodes);
    this.renderer = new Renderer(this.canvas, report, fields);
    this.camera = new SharedCamera(surface, view, () => this.request());
    this.tooltip = new Tooltip(report, fields);
    this.element.append(this.tooltip.element);
    this.drawn = new Promise((resolve) => (this.reportDrawn = resolve));
    this.listen(surface);
  }

  /** Variants that are not hidden; the isolated one alone if there is one. */
  get chosen(): Variant[] {
    const { isolated, hidden } = this.view.now;
    return this.report.variants.filter((v) =>
      isolated === null ? !hidden.has(v.name) : v.name === isolated,
    );
  }

  /** Those of them on the present page. */
  get onPage(): Variant[] {
    const first = this.view.now.page * this.capacity;
    return this.chosen.slice(first, first + this.capacity);
  }

  /** Looks at the whole of the variants from a side. */
  look(name: NamedCamera): void {
    this.outline ??= this.report.outline();
    this.camera.setOutline(this.outline, this.view.now.exaggeration);
    // Name above and badge below need their lines.
    const height = this.tiles.find((tile) => !tile.element.hidden)?.element.clientHeight ?? 400;
    this.camera.look(name, { x: 0.95, y: Math.max(1 - 58 / height, 0.6) });
    this.view.set({ camera: name });
    this.request();
  }

  /** Draws before the next repaint. */
  request(): void {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => this.drawNow());
  }

  drawNow(): void {
    this.pending = false;
    if (!this.canvas.isConnected || this.canvas.clientWidth === 0) return;
    this.renderer.clear();
    const origin = this.canvas.getBoundingClientRect();
    const shown = new Set(this.onPage);
    for (const tile of this.tiles) {
      if (!shown.has(tile.variant)) continue;
      if (tile.variant.hasShape) {
        const part = within(tile.element.getBoundingClientRect(), origin);
        this.camera.setAspect(part.width / part.height);
        this.renderer.draw(tile.variant, part, this.camera.camera, this.view.now, this.marked);
      }
      this.updateTile(tile);
    }
    this.reportDrawn();
  }

  /** Arranges the tiles, for the present size of the window. */
  layout(): void {
    const width = this.grid.clientWidth;
    if (width === 0) return;
    const chosen = this.chosen;
    const grid = chooseGrid(chosen.length, width, this.room(chosen.length));
    this.capacity = grid.capacity;
    const pages = Math.max(1, Math.ceil(chosen.length / grid.capacity));
    if (this.view.now.page >= pages) this.view.set({ page: pages - 1 });
    const shown = new Set(this.onPage);
    for (const tile of this.tiles) tile.element.hidden = !shown.has(tile.variant);
    this.grid.style.gridTemplateColumns = `repeat(${grid.columns}, minmax(0, 1fr))`;
    this.grid.style.gridTemplateRows = `repeat(${grid.rows}, minmax(0, 1fr))`;
    this.grid.style.height = `${grid.height}px`;
    this.showPager(pages);
    this.renderer.resize(width, grid.height);
    const first = this.tiles.find((tile) => shown.has(tile.variant));
    if (first) this.camera.setAspect(first.element.clientWidth / first.element.clientHeight);
    const { camera } = this.view.now;
    if (camera !== 'free') this.look(camera);
    this.request();
  }

  /** The height that the tiles should have: to the end of the window, if that is enough. */
  private room(count: number): number {
    const top = this.element.getBoundingClientRect().top + scrollY;
    const left = innerHeight - top - kBelow;
    const least = innerHeight * (count > 12 ? 0.75 : 0.5);
    return Math.min(Math.max(left, least, 280), 1600);
  }

  private listen(surface: HTMLElement): void {
    const { view } = this;
    view.on(['at', 'field', 'clip', 'lines', 'ghost'], () => this.request());
    view.on(['hidden', 'isolated', 'page'], () => this.layout());
    view.on(['exaggeration'], () => {
      const { camera } = view.now;
      if (camera !== 'free') this.look(camera);
      this.request();
    });
    new ResizeObserver(() => this.layout()).observe(this.element);
    addEventListener('resize', () => this.layout());
    addEventListener('beforeprint', () => this.drawNow());
    onThemeChange(() => {
      this.renderer.applyTheme();
      this.drawNow();
    });
    let down: { x: number; y: number } | null = null;
    surface.addEventListener('pointerdown', (e) => {
      down = { x: e.clientX, y: e.clientY };
      this.hover(null);
    });
    surface.addEventListener('pointerup', (e) => {
      const still = down && Math.hypot(e.clientX - down.x, e.clientY - down.y) < 4;
      if (still && e.button === 0) this.toggleIsolated(e);
      down = null;
    });
    surface.addEventListener('pointermove', (e) => this.hover(e.buttons === 0 ? e : null));
    surface.addEventListener('pointerleave', () => this.hover(null));
  }

  private tileAt(e: PointerEvent): Tile | null {
    const shown = new Set(this.onPage);
    for (const tile of this.tiles) {
      const box = tile.element.getBoundingClientRect();
      const inside =
        e.clientX >= box.left && e.clientX < box.right && e.clientY >= box.top &&
        e.clientY < box.bottom;
      if (inside && shown.has(tile.variant)) return tile;
    }
    return null;
  }

  private toggleIsolated(e: PointerEvent): void {
    const tile = this.tileAt(e);
    if (!tile || this.report.variants.length === 1) return;
    const { isolated } = this.view.now;
    this.view.set({ isolated: isolated === null ? tile.variant.name : null });
  }

  /** Points at the node below the pointer, in every tile. */
  private hover(e: PointerEvent | null): void {
    const tile = e && !this.view.now.playing ? this.tileAt(e) : null;
    let node: number | null = null;
    if (e && tile?.variant.hasShape) {
      const box = tile.element.getBoundingClientRect();
      const point = {
        x: (2 * (e.clientX - box.left)) / box.width - 1,
        y: 1 - (2 * (e.clientY - box.top)) / box.height,
      };
      this.camera.setAspect(box.width / box.height);
      const hit = this.renderer.pick(tile.variant, point, this.camera.camera);
      const r = this.renderer.shownPositions(tile.variant);
      if (hit && r) {
        node = hit.node;
        this.tooltip.show(tile.variant, hit, r, this.view.now.field, e);
      }
    }
    if (node === null) this.tooltip.hide();
    if (node !== this.marked) {
      this.marked = node;
      this.request();
    }
  }

  private updateTile(tile: Tile): void {
    const { variant } = tile;
    const { at, isolated } = this.view.now;
    // Turning the camera changes no figure.
    const moment = `${at} ${isolated}`;
    if (tile.shownMoment === moment) return;
    tile.shownMoment = moment;
    const r = variant.hasShape ? this.renderer.shownPositions(variant) : null;
    const { reference } = this.report;
    let distance: number | null = null;
    if (r && reference?.hasShape && reference !== variant) {
      reference.positionsAt(variant.shownFrame(at), this.rScratch);
      distance = Report.largestDistance(r, this.rScratch);
    }
    const creased = r ? this.report.mesh.creasedShare(r) : null;
    tile.update(at, { creased, distance }, isolated === variant.name);
  }

  private showPager(pages: number): void {
    this.pager.hidden = pages <= 1;
    if (pages <= 1) return;
    const { page } = this.view.now;
    const turn = (text: string, label: string, to: number) =>
      h(
        'button',
        {
          type: 'button',
          'aria-label': label,
          disabled: to < 0 || to >= pages,
          on: { click: () => this.view.set({ page: to }) },
        },
        text,
      );
    const first = page * this.capacity;
    const text = `${first + 1}–${first + this.onPage.length} of ${this.chosen.length} variants`;
    this.pager.replaceChildren(
      turn('‹', 'Previous page', page - 1),
      h('span', { 'aria-live': 'polite' }, text),
      turn('›', 'Next page', page + 1),
    );
  }
}

function within(box: DOMRect, origin: DOMRect): Rectangle {
  return {
    x: box.left - origin.left,
    y: box.top - origin.top,
    width: box.width,
    height: box.height,
  };
}
