// Play, pause, the slider, and on it the moments at which variants leave or end.
import { h, icon } from './dom';
import { formatNumber, formatQuantity } from './format';
import type { Report } from './report';
import { cssColourOf } from './status';
import type { ViewStore } from './view';

/** The whole recording plays in so many seconds. */
const kPlaySeconds = 8;

export function timebar(report: Report, view: ViewStore): HTMLElement {
  const play = h('button', { type: 'button', class: 'play' });
  const slider = h('input', {
    type: 'range',
    min: 0,
    max: report.lastFrame,
    step: 1,
    'aria-label': 'Time',
  });
  const readout = h('output', { class: 'time' });
  const track = h('div', { class: 'track' }, slider);
  const update = () => {
    const { at, playing } = view.now;
    const frame = Math.round(at);
    const step = report.data.frames.steps[frame] ?? 0;
    slider.value = String(frame);
    const text = `t = ${formatQuantity(report.time(at), 's')}`;
    slider.setAttribute('aria-valuetext', `${formatNumber(report.time(at))} seconds, step ${step}`);
    readout.replaceChildren(h('b', {}, text), ` step ${step}`);
    const label = playing ? 'Pause' : 'Play';
    if (play.title !== label) {
      play.title = label;
      play.setAttribute('aria-label', label);
      play.replaceChildren(icon(playing ? 'pause' : 'play'));
    }
  };
  const mark = () => {
    track.querySelectorAll('.event').forEach((e) => e.remove());
    track.append(...events(report, view));
  };
  slider.addEventListener('input', () => view.set({ at: Number(slider.value), playing: false }));
  play.addEventListener('click', () => togglePlay(report, view));
  view.on(['at', 'playing'], update);
  view.on(['hidden'], mark);
  update();
  mark();
  runClock(report, view);
  listenToKeys(report, view);
  return h('section', { class: 'timebar', 'aria-label': 'Time' }, play, track, readout);
}

function togglePlay(report: Report, view: ViewStore): void {
  const { playing, at } = view.now;
  if (playing) view.set({ playing: false, at: Math.round(at) });
  else view.set({ playing: true, at: at >= report.lastFrame ? 0 : at });
}

/** Small flags at the moments when a variant leaves the reference or ends early. */
function events(report: Report, view: ViewStore): HTMLElement[] {
  return report.variants.flatMap((variant) => {
    if (view.now.hidden.has(variant.name)) return [];
    const { parts, frames, status } = variant.data;
    const end = variant.isDone ? undefined : report.data.frames.times[Math.max(frames - 1, 0)];
    const time = end ?? parts?.time;
    if (time === undefined) return [];
    const at = report.nearestFrame(time) / Math.max(report.lastFrame, 1);
    const what = end === undefined ? `leaves ${report.data.reference}` : status;
    return [
      h('span', {
        class: 'event',
        style: `--at: ${at}; --colour: ${cssColourOf(variant)}`,
        title: `${variant.name}: ${what} at ${formatQuantity(time, 's')}`,
      }),
    ];
  });
}

function runClock(report: Report, view: ViewStore): void {
  let last = 0;
  const tick = (now: number) => {
    const { playing, at } = view.now;
    if (!playing) return;
    const speed = Math.max(report.lastFrame, 1) / kPlaySeconds;
    // A tab in the background sleeps; it must not jump when it wakes. The first frame may have
    // begun before the button was pressed.
    const next = at + speed * Math.min(Math.max(now - last, 0) / 1000, 0.1);
    last = now;
    if (next >= report.lastFrame) view.set({ at: report.lastFrame, playing: false });
    else view.set({ at: next });
    requestAnimationFrame(tick);
  };
  view.on(['playing'], () => {
    if (!view.now.playing) return;
    last = performance.now();
    requestAnimationFrame(tick);
  });
}

function listenToKeys(report: Report, view: ViewStore): void {
  const step = (by: number) => {
    const at = Math.round(view.now.at) + by;
    view.set({ at: Math.min(Math.max(at, 0), report.lastFrame), playing: false });
  };
  const acts: Record<string, () => void> = {
    ' ': () => togglePlay(report, view),
    ArrowLeft: () => step(-1),
    ArrowRight: () => step(1),
    Home: () => step(-Infinity),
    End: () => step(Infinity),
    Escape: () => view.set({ isolated: null }),
  };
  addEventListener('keydown', (event) => {
    const act = acts[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target as HTMLElement;
    // What has the focus may want the key for itself.
    const needsSpace = target.closest('button, summary, select, input:not([type=range])');
    const needsArrows = target.closest('select, input');
    if (event.key === ' ' ? needsSpace : event.key !== 'Escape' && needsArrows) return;
    event.preventDefault();
    act();
  });
}
