// How tiles share the stage.
export interface Grid {
  columns: number;
  rows: number;
  /** Tiles on one page. */
  capacity: number;
  /** Height of the stage [CSS px]. */
  height: number;
}

const kGap = 6;
/** Tiles smaller than this are unreadable; what does not fit goes to the next page. */
const kLeast = { width: 148, height: 122 };
/** Width over height of a tile that suits a sheet seen from above at an angle. */
const kShape = 1.3;

/** The grid of `count` tiles that makes them largest on a stage of `width` × about `height`. */
export function chooseGrid(count: number, width: number, height: number): Grid {
  let best: Grid | null = null;
  let bestSize = 0;
  for (let columns = 1; columns <= Math.max(count, 1); ++columns) {
    const rows = Math.ceil(count / columns) || 1;
    const w = (width - kGap * (columns - 1)) / columns;
    const h = (height - kGap * (rows - 1)) / rows;
    if (count > 1 && (w < kLeast.width || h < kLeast.height)) continue;
    const size = Math.min(w, h * kShape);
    if (size > bestSize) {
      // One row of narrow tiles needs not the whole height.
      const used = Math.min(h, Math.max(w / 1.05, kLeast.height));
      best = { columns, rows, capacity: count, height: used * rows + kGap * (rows - 1) };
      bestSize = size;
    }
  }
  if (best) return best;
  const columns = Math.max(1, Math.floor((width + kGap) / (kLeast.width + kGap)));
  const rows = Math.max(1, Math.floor((height + kGap) / (kLeast.height + kGap)));
  return { columns, rows, capacity: columns * rows, height };
}
