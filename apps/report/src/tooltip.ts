// What is known of the node below the pointer.
import { h, dot } from './dom';
import { kPlain, type Fields } from './fields';
import { formatNumber, formatQuantity } from './format';
import type { Hit } from './renderer';
import type { Report } from './report';
import { cssColourOf } from './status';
import type { Variant } from './variant';

export class Tooltip {
  readonly element = h('div', { class: 'tooltip', role: 'status', hidden: true });

  constructor(
    private readonly report: Report,
    private readonly fields: Fields,
  ) {}

  show(variant: Variant, hit: Hit, r: Float32Array, fieldName: string, e: PointerEvent): void {
    const { mesh } = this.report;
    const rows: [string, string][] = [];
    const field = this.fields.find(fieldName);
    if (field && field.name !== kPlain) {
      const label = field.scale === 'categorical' ? field.labels[hit.value] : undefined;
      rows.push([field.name, label ?? formatQuantity(hit.value, field.unit)]);
    }
    const [x, y, z] = r.subarray(3 * hit.node, 3 * hit.node + 3);
    rows.push(['position', `(${[x, y, z].map((c) => formatNumber(c)).join(', ')}) m`]);
    if (mesh.parameters) {
      const [a1, a2] = mesh.parameters.subarray(2 * hit.node, 2 * hit.node + 2);
      rows.push(['parameter', `(${formatNumber(a1)}, ${formatNumber(a2)})`]);
    }
    rows.push(['node', String(mesh.number(hit.node))]);
    this.element.replaceChildren(
      h('strong', {}, dot(cssColourOf(variant)), variant.name),
      h('dl', {}, ...rows.flatMap(([term, text]) => [h('dt', {}, term), h('dd', {}, text)])),
    );
    this.element.hidden = false;
    const { offsetWidth, offsetHeight } = this.element;
    const left = Math.min(e.clientX + 16, innerWidth - offsetWidth - 8);
    const above = e.clientY + 16 + offsetHeight > innerHeight;
    this.element.style.left = `${Math.max(left, 8)}px`;
    this.element.style.top = `${above ? e.clientY - offsetHeight - 12 : e.clientY + 16}px`;
  }

  hide(): void {
    this.element.hidden = true;
  }
}
