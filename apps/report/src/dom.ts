// Elements without innerHTML: text of a report can never become markup.
type Child = Node | string | null | undefined | false;
type Listeners = Record<string, (event: never) => void>;
type Properties = Record<string, unknown> & { class?: string; on?: Listeners };

/** An element; properties are set as attributes, `on` holds listeners. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Properties = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name === 'on') {
      for (const [event, listener] of Object.entries(properties.on ?? {})) {
        element.addEventListener(event, listener as EventListener);
      }
    } else if (value === true) {
      element.setAttribute(name, '');
    } else if (value !== false && value !== null && value !== undefined) {
      element.setAttribute(name, String(value));
    }
  }
  element.append(...children.filter((c): c is Node | string => !!c || c === ''));
  return element;
}

/** The dot in a variant's colour that stands beside its name everywhere. */
export function dot(colour: string): HTMLElement {
  return h('span', { class: 'dot', style: `--colour: ${colour}`, 'aria-hidden': 'true' });
}

const kIcons: Record<string, string> = {
  play: 'M7 4v16l13-8z',
  pause: 'M6 4h4v16H6zM14 4h4v16h-4z',
  enlarge: 'M4 10V4h6v2H7.4l4 4L10 11.4l-4-4V10zM20 14v6h-6v-2h2.6l-4-4 1.4-1.4 4 4V14z',
  close: 'M6 5l6 6 6-6 1.4 1.4-6 6 6 6L18 19.8l-6-6-6 6-1.4-1.4 6-6-6-6z',
};

export function icon(name: keyof typeof kIcons & string): SVGElement {
  const space = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(space, 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS(space, 'path');
  path.setAttribute('d', kIcons[name]);
  svg.append(path);
  return svg;
}
