// What scripts can ask of the page: window.deformReport.
import { contactSheet, type SheetOptions } from './contact_sheet';
import type { Fields } from './fields';
import type { Report } from './report';
import type { Stage } from './stage';
import type { NamedCamera, ViewStore } from './view';

export interface ReportApi {
  /** Resolves when the first picture has been drawn; rejects if the page shows no report. */
  ready: Promise<void>;
  /** Shows frame i of `frames`. */
  setTime(i: number): void;
  setField(name: string): void;
  /** Shows these variants alone; all of them for an empty list. */
  only(names: string[]): void;
  setCamera(camera: NamedCamera | number[]): void;
  /** Position [m] of a shown node of a variant, as drawn now. */
  position(variant: string, node: number): number[];
  /** A PNG data URL of variants × moments. */
  contactSheet(options?: SheetOptions): Promise<string>;
}

declare global {
  interface Window {
    deformReport: ReportApi;
  }
}

export function api(report: Report, fields: Fields, view: ViewStore, stage: Stage): ReportApi {
  const known = (name: string) => {
    const variant = report.variant(name);
    if (!variant) throw new Error(`there is no variant '${name}'`);
    return variant;
  };
  return {
    ready: stage.drawn,
    setTime(i) {
      if (!Number.isInteger(i) || i < 0 || i > report.lastFrame) {
        throw new Error(`there is no frame ${i}; frames go from 0 to ${report.lastFrame}`);
      }
      view.set({ at: i, playing: false });
      stage.drawNow();
    },
    setField(name) {
      if (!fields.find(name)) {
        const names = fields.all.map((f) => f.name).join(', ');
        throw new Error(`there is no field '${name}'; there are: ${names}`);
      }
      view.set({ field: name });
      stage.drawNow();
    },
    only(names) {
      const shown = names.map((name) => known(name).name);
      const rest = report.variants.map((v) => v.name).filter((n) => !shown.includes(n));
      view.set({ hidden: new Set(shown.length > 0 ? rest : []), isolated: null, page: 0 });
      stage.drawNow();
    },
    setCamera(camera) {
      if (Array.isArray(camera)) {
        view.set({ camera: 'free' });
        stage.camera.setFree(camera);
      } else {
        stage.look(camera);
      }
      stage.drawNow();
    },
    position(name, node) {
      const r = stage.renderer.shownPositions(known(name));
      if (!r) throw new Error(`'${name}' is not drawn`);
      return Array.from(r.subarray(3 * node, 3 * node + 3));
    },
    contactSheet: (options) => contactSheet(report, fields, stage, view.now, options),
  };
}
