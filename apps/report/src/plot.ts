// One probed quantity of all variants over time.
import uPlot from 'uplot';
import { h } from './dom';
import { formatNumber, formatQuantity, withUnit } from './format';
import type { Report } from './report';
import { colourOf, cssColourOf } from './status';
import { themeColour } from './theme';
import type { Variant } from './variant';
import type { ViewStore } from './view';

export interface Quantity {
  name: string;
  unit: string;
}

const kHeight = 190;
type Column = (number | null | undefined)[];

export class Plot {
  readonly element: HTMLElement;
  private readonly area = h('div', { class: 'plot-area' });
  private readonly readout = h('span', { class: 'plot-readout' });
  private readonly cursor = h('div', { class: 'plot-cursor' });
  private readonly logarithmic = h('input', { type: 'checkbox' });
  private readonly variants: Variant[];
  /** Times, then a column for each variant. */
  private readonly table: Column[];
  private plot: uPlot | null = null;

  constructor(
    private readonly report: Report,
    private readonly view: ViewStore,
    quantity: Quantity,
  ) {
    this.variants = report.variants.filter((v) => column(v, quantity.name) > 1);
    // A diverged variant stops earlier, another may have other steps: one axis for all.
    const tables = this.variants.map((v) => series(v, quantity.name));
    this.table = uPlot.join(tables as uPlot.AlignedData[]) as Column[];
    this.logarithmic.addEventListener('change', () => this.redraw());
    const title = h('h3', {}, withUnit(quantity.name, quantity.unit));
    const log = h('label', { class: 'toggle' }, this.logarithmic, 'log');
    this.element = h(
      'figure',
      { class: 'plot', 'data-probe': quantity.name },
      h('figcaption', {}, title, this.readout, log),
      this.area,
    );
  }

  draw(): void {
    if (this.plot || this.area.clientWidth === 0) return;
    this.plot = new uPlot(this.options(), this.values(), this.area);
    this.plot.over.append(this.cursor);
    this.listen(this.plot);
    this.moveCursor();
  }

  /** Draws again from the beginning, if it was drawn at all. */
  redraw(): void {
    if (!this.plot) return;
    this.plot.destroy();
    this.plot = null;
    this.draw();
  }

  resize(): void {
    const width = this.area.clientWidth;
    if (this.plot && width > 0 && width !== this.plot.width) {
      this.plot.setSize({ width, height: kHeight });
      this.moveCursor();
    }
  }

  moveCursor(): void {
    if (!this.plot) return;
    const x = this.plot.valToPos(this.report.time(this.view.now.at), 'x');
    this.cursor.style.transform = `translateX(${x}px)`;
    this.cursor.hidden = !(x >= 0 && x <= this.plot.over.clientWidth);
  }

  showChosen(): void {
    this.plot?.batch(() => {
      this.variants.forEach((v, i) => {
        const show = this.isChosen(v);
        if (this.plot?.series[i + 1].show !== show) this.plot?.setSeries(i + 1, { show });
      });
    });
  }

  private isChosen(variant: Variant): boolean {
    const { isolated, hidden } = this.view.now;
    return isolated === null || this.variants.every((v) => v.name !== isolated)
      ? !hidden.has(variant.name)
      : variant.name === isolated || variant.isReference;
  }

  /** The table as drawn: on a logarithmic scale, of quantities with a sign, the absolute values. */
  private values(): uPlot.AlignedData {
    if (!this.logarithmic.checked) return this.table as uPlot.AlignedData;
    const positive = (x: number | null | undefined) => (x ? Math.abs(x) : x === 0 ? null : x);
    return [this.table[0], ...this.table.slice(1).map((c) => c.map(positive))] as uPlot.AlignedData;
  }

  private options(): uPlot.Options {
    const ink = themeColour('--muted');
    const grid = { stroke: themeColour('--rule'), width: 1 };
    const font = `11px ${getComputedStyle(this.area).fontFamily}`;
    const axis: uPlot.Axis = { stroke: ink, grid, ticks: { ...grid, size: 4 }, font, gap: 3 };
    const logarithmic = this.logarithmic.checked;
    return {
      width: this.area.clientWidth,
      height: kHeight,
      legend: { show: false },
      padding: [8, 10, 0, 0],
      focus: { alpha: 0.25 },
      cursor: {
        focus: { prox: 24 },
        points: { size: 6 },
        sync: { key: 'probes', scales: ['x', null] },
        drag: { x: true, y: false },
      },
      scales: {
        x: { time: false },
        y: { distr: logarithmic ? 3 : 1, range: (_u, low, high) => this.range(low, high) },
      },
      axes: [
        { ...axis, size: 26, values: (_u, ticks) => ticks.map((t) => formatQuantity(t, 's')) },
        {
          ...axis,
          size: 58,
          values: (_u, ticks) => ticks.map((t) => (t === null ? null : formatNumber(t))),
        },
      ],
      series: [
        { label: 'time', value: (_u, t) => formatQuantity(t, 's') },
        ...this.variants.map((v) => this.line(v)),
      ],
      hooks: { setSeries: [(u, i) => this.showReadout(u, i)], setSize: [() => this.moveCursor()] },
    };
  }

  private line(variant: Variant): uPlot.Series {
    return {
      label: variant.name,
      stroke: colourOf(variant),
      width: variant.isReference ? 2.5 : 1.75,
      dash: variant.isReference ? [7, 4] : undefined,
      show: this.isChosen(variant),
      spanGaps: false,
      points: { show: false },
    };
  }

  /** Those that ran to their end set the scale; one that explodes runs out of the picture. */
  private range(low: number | null, high: number | null): uPlot.Range.MinMax {
    const values = this.values();
    let [from, to] = [Infinity, -Infinity];
    this.variants.forEach((v, i) => {
      if (!v.isDone || !this.isChosen(v)) return;
      for (const x of values[i + 1]) {
        if (x === null || x === undefined) continue;
        if (x < from) from = x;
        if (x > to) to = x;
      }
    });
    if (from > to) [from, to] = [low ?? 0, high ?? 1];
    if (this.logarithmic.checked) {
      // Twelve decades say everything; the rest is rounding.
      return uPlot.rangeLog(Math.max(from, to * 1e-12) || 1e-12, to || 1, 10, false);
    }
    return uPlot.rangeNum(from, to, 0.08, true);
  }

  private showReadout(u: uPlot, i: number | null): void {
    const row = u.cursor.idx;
    if (i === null || i < 1 || row === null || row === undefined) {
      this.readout.textContent = '';
      return;
    }
    const value = this.table[i][row];
    const variant = this.variants[i - 1];
    this.readout.textContent = `${variant.name}: ${formatNumber(value)}`;
    this.readout.style.setProperty('--colour', cssColourOf(variant));
  }

  /** A click sets the moment; dragging zooms, a double click shows all again. */
  private listen(plot: uPlot): void {
    let down = 0;
    plot.over.addEventListener('mousedown', (e) => (down = e.clientX));
    plot.over.addEventListener('click', (e) => {
      if (Math.abs(e.clientX - down) > 3) return;
      const x = e.clientX - plot.over.getBoundingClientRect().left;
      const at = this.report.nearestFrame(plot.posToVal(x, 'x'));
      this.view.set({ at, playing: false });
    });
    plot.over.addEventListener('dblclick', () => requestAnimationFrame(() => this.moveCursor()));
    plot.hooks.setScale = [() => requestAnimationFrame(() => this.moveCursor())];
  }
}

function column(variant: Variant, name: string): number {
  return variant.data.probes.columns.findIndex((c) => c.name === name);
}

function series(variant: Variant, name: string): [Column, Column] {
  const at = column(variant, name);
  const { rows } = variant.data.probes;
  return [rows.map((row) => row[1]), rows.map((row) => row[at])];
}
