// Puts the page together.
import 'uplot/dist/uPlot.min.css';
import './style.css';
import { api, type ReportApi } from './api';
import { chips } from './chips';
import { contactSheet, fittingOptions } from './contact_sheet';
import { readReport } from './contract';
import { changesTable, details } from './details';
import { h } from './dom';
import { Fields } from './fields';
import { asksForSheet, cameraFromHash, keepHash, viewFromHash } from './hash';
import { plots } from './plots';
import { Report } from './report';
import { Stage } from './stage';
import { watchTheme } from './theme';
import { timebar } from './timebar';
import { toolbar } from './toolbar';
import { header, verdictTable } from './verdict';
import { ViewStore } from './view';

function firstView(report: Report, fields: Fields): ViewStore {
  return new ViewStore({
    // The end says most: who has folded, who has not.
    at: report.lastFrame,
    playing: false,
    field: fields.first,
    hidden: new Set(),
    isolated: null,
    page: 0,
    clip: true,
    lines: true,
    ghost: false,
    exaggeration: 1,
    camera: 'fit',
    ...viewFromHash(report, fields),
  });
}

function build(page: HTMLElement): void {
  const report = new Report(readReport());
  document.title = report.data.title;
  const fields = new Fields(report);
  const view = firstView(report, fields);
  const parts: (HTMLElement | null)[] = [header(report)];
  const stage = makeStage(report, fields, view);
  if (stage instanceof Stage) {
    const save = () => void saveSheet(report, fields, view, stage);
    const time = report.frameCount > 1 ? timebar(report, view) : null;
    const tools = toolbar(report, fields, view, stage, save);
    parts.push(chips(report, view), tools, stage.element, time);
  } else {
    parts.push(stage);
  }
  parts.push(verdictTable(report), plots(report, view), changesTable(report), details(report));
  page.append(...parts.filter((part) => part !== null));
  if (!(stage instanceof Stage)) return;
  const camera = cameraFromHash();
  if (camera) stage.camera.setFree(camera);
  stage.layout();
  keepHash(report, fields, view, stage);
  window.deformReport = api(report, fields, view, stage);
  void stage.drawn.then(() => performance.mark('first picture'));
  if (asksForSheet()) void showSheet(report, fields, view, stage);
}

/** The 3-D views; or, where there is no WebGL, a sentence: figures and plots need none. */
function makeStage(report: Report, fields: Fields, view: ViewStore): Stage | HTMLElement {
  try {
    return new Stage(report, fields, view);
  } catch (error) {
    if (document.createElement('canvas').getContext('webgl2')) throw error;
    const message = 'This browser has no WebGL 2, so the surfaces cannot be shown.';
    return h('p', { class: 'failure' }, message);
  }
}

async function saveSheet(
  report: Report,
  fields: Fields,
  view: ViewStore,
  stage: Stage,
): Promise<void> {
  const name = `${report.data.title.replace(/[^\w-]+/g, '_').slice(0, 60)}.png`;
  const href = await contactSheet(report, fields, stage, view.now);
  h('a', { href, download: name }).click();
}

/** The sheet in place of the page, for who reads the document of a browser without a window. */
async function showSheet(
  report: Report,
  fields: Fields,
  view: ViewStore,
  stage: Stage,
): Promise<void> {
  try {
    const options = fittingOptions(stage.chosen);
    const src = await contactSheet(report, fields, stage, view.now, options);
    page.replaceChildren(h('img', { id: 'contact-sheet', alt: 'Contact sheet', src }));
  } catch (error) {
    page.replaceChildren(failure(error));
  }
}

function failure(error: unknown): HTMLElement {
  const message = error instanceof Error ? error.message : String(error);
  return h('p', { class: 'failure', role: 'alert' }, message);
}

const page = document.getElementById('page')!;
watchTheme();
try {
  build(page);
} catch (error) {
  page.replaceChildren(failure(error));
  const ready = Promise.reject(error);
  ready.catch(() => {}); // whoever waits for it hears of it; nobody has to
  window.deformReport = { ready } as Partial<ReportApi> as ReportApi;
}
