// Variants × moments in one picture, on white, with names, times and the colour scale: for papers.
import { categoryColour, gradientStops } from './colormap';
import { kPlain, type Fields } from './fields';
import { formatNumber, formatQuantity, roundTicks, withUnit } from './format';
import type { Report } from './report';
import type { Stage } from './stage';
import { badge } from './status';
import { variantColour } from './colour';
import type { Variant } from './variant';
import type { View } from './view';

export interface SheetOptions {
  /** Frames, one a column; five even ones if missing. */
  columns?: number[];
  /** Names, one a row; those that are shown if missing. */
  variants?: string[];
  /** Size of one picture in pixels. */
  width?: number;
  height?: number;
  /** What is to be said about the whole. */
  note?: string;
}

const kWidth = 400;
/** Height of a picture for its width. */
const kAspect = 0.72;
/** Of the pictures, in pixels: browsers have canvases of some 16000, other programs less. */
const kMostHeight = 9000;
const kMostRows = 100;
const kInk = '#1b1f24';
const kMuted = '#5b6570';
const kPaper = '#ffffff';
/** Room for names on the left, for times on top, for the colour scale below, at width 400. */
const kMargins = { left: 190, top: 40, bottom: 84 };

/** `count` frames from the first to the last, evenly. */
export function evenFrames(report: Report, count: number): number[] {
  const last = report.lastFrame;
  const frames = Array.from({ length: count }, (_, i) => Math.round((i * last) / (count - 1)));
  return [...new Set(frames)];
}

/** What a sheet of these variants has to leave out and make smaller so as not to be too high. */
export function fittingOptions(variants: Variant[]): SheetOptions {
  const rows = variants.filter((v) => v.hasShape);
  const shown = rows.slice(0, kMostRows);
  const width = Math.min(kWidth, Math.floor(kMostHeight / kAspect / Math.max(shown.length, 1)));
  const note =
    shown.length < rows.length ? `the first ${kMostRows} of ${rows.length} variants` : '';
  return { variants: shown.map((v) => v.name), width, note };
}

/** The sheet as a PNG data URL. */
export async function contactSheet(
  report: Report,
  fields: Fields,
  stage: Stage,
  view: Readonly<View>,
  options: SheetOptions = {},
): Promise<string> {
  await stage.drawn;
  const columns = options.columns ?? evenFrames(report, 5);
  for (const frame of columns) {
    if (!Number.isInteger(frame) || frame < 0 || frame > report.lastFrame) {
      throw new Error(`there is no frame ${frame}; frames go from 0 to ${report.lastFrame}`);
    }
  }
  const rows = options.variants
    ? options.variants.map((name) => find(report, name))
    : stage.chosen.filter((v) => v.hasShape);
  if (rows.length === 0) throw new Error('there is no shape to show');
  const width = options.width ?? kWidth;
  const height = options.height ?? Math.round(width * kAspect);
  const unit = width / kWidth;
  const margins = {
    left: Math.round(kMargins.left * unit),
    top: Math.round(kMargins.top * unit),
    bottom: Math.round(kMargins.bottom * unit),
  };
  const canvas = document.createElement('canvas');
  canvas.width = margins.left + width * columns.length;
  canvas.height = margins.top + height * rows.length + margins.bottom;
  const pen = canvas.getContext('2d');
  if (!pen) throw new Error('this browser gives no canvas of that size');
  pen.fillStyle = kPaper;
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.textBaseline = 'middle';
  columns.forEach((frame, i) => {
    const x = margins.left + width * (i + 0.5);
    write(pen, `t = ${formatQuantity(report.time(frame), 's')}`, x, margins.top / 2, 17 * unit);
  });
  stage.camera.setAspect(width / height);
  if (view.camera !== 'free') stage.camera.look(view.camera, { x: 0.94, y: 0.94 });
  const nameSize = fittingSize(pen, rows, margins.left - 40 * unit, 17 * unit);
  rows.forEach((variant, j) => {
    const y = margins.top + height * j;
    rowHead(pen, report, variant, y + height / 2, nameSize, unit);
    columns.forEach((at, i) => {
      const x = margins.left + width * i;
      const size = { width, height };
      const moment = { ...view, at };
      if (!variant.hasShape) return;
      const picture = stage.renderer.picture(variant, size, stage.camera.camera, moment, kPaper);
      pen.putImageData(picture, x, y);
      if (at > variant.data.frames - 1) {
        plate(pen, variant.data.status, x + width / 2, y + 18 * unit, 15 * unit);
      }
    });
  });
  scale(pen, fields, view, canvas.width, canvas.height - margins.bottom / 2, unit);
  if (options.note) {
    const y = canvas.height - margins.bottom / 2;
    write(pen, options.note, 14 * unit, y, 15 * unit, kMuted, 'left');
  }
  stage.layout();
  return canvas.toDataURL('image/png');
}

function find(report: Report, name: string): Variant {
  const variant = report.variant(name);
  if (variant) return variant;
  const names = report.variants.map((v) => v.name).join(', ');
  throw new Error(`there is no variant '${name}'; there are: ${names}`);
}

function write(
  pen: CanvasRenderingContext2D,
  text: string,
  x: number,
  y: number,
  size: number,
  colour = kInk,
  align: CanvasTextAlign = 'center',
  weight = 400,
): void {
  pen.font = `${weight} ${size}px system-ui, sans-serif`;
  pen.fillStyle = colour;
  pen.textAlign = align;
  pen.fillText(text, x, y);
}

/** Text on a plate of its own: what is below may have any colour. */
function plate(
  pen: CanvasRenderingContext2D,
  text: string,
  x: number,
  y: number,
  size: number,
): void {
  pen.font = `600 ${size}px system-ui, sans-serif`;
  const wide = pen.measureText(text).width + size;
  pen.fillStyle = '#fbe5e0';
  pen.fillRect(x - wide / 2, y - size * 0.8, wide, size * 1.6);
  write(pen, text, x, y, size, '#bd2c18', 'center', 600);
}

/** The size at which the longest name fits; names are made smaller rather than cut. */
function fittingSize(
  pen: CanvasRenderingContext2D,
  rows: Variant[],
  room: number,
  size: number,
): number {
  pen.font = `600 ${size}px system-ui, sans-serif`;
  const widest = Math.max(1, ...rows.map((v) => pen.measureText(v.name).width));
  return size * Math.min(1, room / widest);
}

function rowHead(
  pen: CanvasRenderingContext2D,
  report: Report,
  variant: Variant,
  y: number,
  size: number,
  unit: number,
): void {
  const x = 14 * unit;
  pen.fillStyle = variant.isReference ? kInk : variantColour(variant.index);
  pen.beginPath();
  pen.arc(x, y - 10 * unit, 6 * unit, 0, 2 * Math.PI);
  pen.fill();
  write(pen, variant.name, x + 14 * unit, y - 10 * unit, size, kInk, 'left', 600);
  const { text } = badge(report, variant, report.lastFrame);
  write(pen, text, x + 14 * unit, y + 13 * unit, 13 * unit, kMuted, 'left');
}

function scale(
  pen: CanvasRenderingContext2D,
  fields: Fields,
  view: Readonly<View>,
  width: number,
  y: number,
  unit: number,
): void {
  const field = fields.find(view.field);
  if (!field || field.name === kPlain) return;
  const title = withUnit(field.name, field.unit);
  write(pen, title, width / 2, y - 26 * unit, 15 * unit);
  if (field.scale === 'categorical') {
    const each = Math.min(180 * unit, width / field.labels.length);
    field.labels.forEach((label, i) => {
      const x = width / 2 + each * (i - field.labels.length / 2);
      pen.fillStyle = categoryColour(i);
      pen.fillRect(x, y - 8 * unit, 16 * unit, 16 * unit);
      write(pen, label, x + 22 * unit, y, 14 * unit, kInk, 'left');
    });
    return;
  }
  const { low, high } = fields.range(view.field, view.clip);
  const long = Math.min(420 * unit, width * 0.7);
  const left = (width - long) / 2;
  const gradient = pen.createLinearGradient(left, 0, left + long, 0);
  const stops = gradientStops(field.scale);
  stops.forEach((colour, i) => gradient.addColorStop(i / (stops.length - 1), colour));
  pen.fillStyle = gradient;
  pen.fillRect(left, y - 10 * unit, long, 14 * unit);
  pen.strokeStyle = kMuted;
  pen.lineWidth = unit;
  pen.strokeRect(left, y - 10 * unit, long, 14 * unit);
  for (const tick of roundTicks(low, high, 4)) {
    const x = left + (long * (tick - low)) / (high - low);
    write(pen, formatNumber(tick), x, y + 18 * unit, 13 * unit, kMuted);
  }
}
