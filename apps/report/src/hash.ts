// The view as part of the address, so that it can be sent, reloaded and set by scripts:
//   #t=1.2&field=B_11&only=exact,gauss&camera=top&z=2&show=lines,ghost,clip
// t in seconds; camera a name or six numbers, position and target.
import type { Fields } from './fields';
import type { Report } from './report';
import type { Stage } from './stage';
import type { NamedCamera, View, ViewStore } from './view';

const kCameras = ['fit', 'top', 'front', 'side'];
const kSwitches = ['lines', 'ghost', 'clip'] as const;

/** What the address asks for; what it asks for in vain is left out. */
export function viewFromHash(report: Report, fields: Fields): Partial<View> {
  const parts = readHash();
  const view: Partial<View> = {};
  const time = Number(parts.get('t')?.[0]);
  if (parts.has('t') && Number.isFinite(time)) view.at = report.nearestFrame(time);
  const field = parts.get('field')?.[0];
  if (field && fields.find(field)) view.field = field;
  const only = parts.get('only')?.filter((name) => report.variant(name));
  if (only && only.length > 0) {
    view.hidden = new Set(report.variants.map((v) => v.name).filter((n) => !only.includes(n)));
  }
  const camera = parts.get('camera') ?? [];
  if (kCameras.includes(camera[0])) view.camera = camera[0] as NamedCamera;
  else if (camera.length === 6 && camera.every((x) => Number.isFinite(Number(x)))) {
    view.camera = 'free';
  }
  const z = Number(parts.get('z')?.[0]);
  if (z > 0 && z <= 1000) view.exaggeration = z;
  const show = parts.get('show');
  if (show) for (const name of kSwitches) view[name] = show.includes(name);
  return view;
}

/** The six numbers of `#camera=`, or null. */
export function cameraFromHash(): number[] | null {
  const numbers = (readHash().get('camera') ?? []).map(Number);
  return numbers.length === 6 && numbers.every(Number.isFinite) ? numbers : null;
}

/** Whether the address asks for the contact sheet in place of the page. */
export function asksForSheet(): boolean {
  return readHash().has('contact-sheet');
}

/** Keeps the address up to date, and follows it when the reader changes it. */
export function keepHash(report: Report, fields: Fields, view: ViewStore, stage: Stage): void {
  let timer = 0;
  const later = () => {
    clearTimeout(timer);
    timer = setTimeout(() => history.replaceState(null, '', hash(report, view.now, stage)), 250);
  };
  view.on(['at', 'field', 'hidden', 'camera', 'exaggeration', ...kSwitches], later);
  stage.element.addEventListener('pointerup', later);
  addEventListener('hashchange', () => {
    view.set({ playing: false, ...viewFromHash(report, fields) });
    const camera = cameraFromHash();
    if (camera) stage.camera.setFree(camera);
    else if (view.now.camera !== 'free') stage.look(view.now.camera);
    stage.request();
  });
}

function hash(report: Report, view: Readonly<View>, stage: Stage): string {
  const list = (values: (string | number)[]) => values.map(encodeURIComponent).join(',');
  const shown = report.variants.map((v) => v.name).filter((name) => !view.hidden.has(name));
  const parts = [`t=${Number(report.time(Math.round(view.at)).toPrecision(6))}`];
  parts.push(`field=${encodeURIComponent(view.field)}`);
  if (view.hidden.size > 0 && shown.length > 0) parts.push(`only=${list(shown)}`);
  const free = () => stage.camera.free.map((x) => Number(x.toPrecision(4)));
  parts.push(`camera=${view.camera === 'free' ? list(free()) : view.camera}`);
  if (view.exaggeration !== 1) parts.push(`z=${view.exaggeration}`);
  parts.push(`show=${list(kSwitches.filter((name) => view[name]))}`);
  return `#${parts.join('&')}`;
}

function readHash(): Map<string, string[]> {
  const parts = new Map<string, string[]>();
  for (const part of location.hash.slice(1).split('&')) {
    const [key, value] = part.split('=', 2);
    if (value === undefined) continue;
    // Names may hold commas; those are encoded, the separating ones are not.
    parts.set(key, value.split(',').map(decode));
  }
  return parts;
}

function decode(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}
