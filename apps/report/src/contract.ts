// What the program writes into the page: docs/report-format.md, format 1.

export type Scale = 'sequential' | 'diverging' | 'categorical';
export type Status =
  | 'done'
  | 'diverged'
  | 'plugin failed'
  | 'interrupted'
  | 'failed'
  | 'refused'
  | 'crashed'
  | 'running';

export interface FieldData {
  name: string;
  unit: string;
  scale: Scale;
  /** Names of the categories 0, 1, …; only with the scale `categorical`. */
  labels?: string[];
  min: number;
  max: number;
  /** base64 of little-endian uint16, frames × nodes. */
  data: string;
}

export interface VariantData {
  name: string;
  status: Status;
  reason: string;
  /** How many of the recorded frames it reached. */
  frames: number;
  positions: { min: number[]; max: number[]; data: string };
  fields: FieldData[];
  probes: { columns: { name: string; unit: string }[]; rows: (number | null)[][] };
  changes: { pointer: string; value: unknown }[];
  /** Pointers of parameters of the base scene that a changed plugin does not have. */
  dropped?: string[];
  cost: Record<string, number | null> | null;
  parts: { step: number; time: number; where: number[]; node: number } | null;
  /** Why it was not measured against the reference; empty or left out: it was. */
  not_measured?: string;
  manifest: unknown;
}

export interface VerdictData {
  columns: { name: string; unit: string; better: 'lower' | 'higher' | null }[];
  rows: { variant: string; values: (number | string | null)[] }[];
  sentences: string[];
}

export interface ReportData {
  format: number;
  kind: 'comparison' | 'run';
  title: string;
  created: string;
  program: string;
  mesh: {
    nodes: number;
    quads?: string;
    triangles?: string;
    /** base64 of little-endian float32, nodes × 2: (a_1, a_2). */
    parameters?: string;
    /** base64 of little-endian uint32: the simulation's number of each shown node. */
    numbers?: string;
  };
  frames: { steps: number[]; times: number[] };
  reference: string | null;
  /** Distance to the reference from which on a variant has parted from it. */
  tolerance?: { value: number; unit: string } | null;
  variants: VariantData[];
  verdict: VerdictData | null;
  scene: unknown;
  notes: string[];
}

/** The data of this page; an error for readers if there is none or it is of another format. */
export function readReport(): ReportData {
  const element = document.getElementById('deform-data');
  const report = JSON.parse(element?.textContent ?? 'null') as ReportData | null;
  if (element) element.textContent = ''; // the text is large and not needed again
  if (!report) throw new Error('This page is a template: it holds no report.');
  if (report.format !== 1) {
    throw new Error(`This page shows reports of format 1; the data has format ${report.format}.`);
  }
  return report;
}
