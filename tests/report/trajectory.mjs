// trajectory.bin as framework/include/deform/record/trajectory.h describes it.
import { readFileSync } from 'node:fs';

export function readTrajectory(path) {
  const file = readFileSync(path);
  const magic = 'deform trajectory 1\n';
  if (file.toString('latin1', 0, magic.length) !== magic) throw new Error(`${path}: no trajectory`);
  const length = Number(file.readBigUInt64LE(magic.length));
  const header = magic.length + 8;
  const text = file.toString('utf8', header, header + length);
  const { nodes, faces, corners, fields, scalars = 0 } = JSON.parse(text);
  const first = header + length + 24 * nodes + 4 * (faces + 1 + corners);
  const bytes = 16 + nodes * (24 + 4 * fields.length) + 8 * scalars;
  const moments = [];
  for (let at = first; at + bytes <= file.length; at += bytes) {
    moments.push({ step: Number(file.readBigInt64LE(at)), time: file.readDoubleLE(at + 8) });
  }
  /** Three arrays, x, y and z of all nodes. */
  const positions = (frame) =>
    [0, 1, 2].map((c) => {
      const at = first + frame * bytes + 16 + 8 * c * nodes;
      return Array.from({ length: nodes }, (_, k) => file.readDoubleLE(at + 8 * k));
    });
  const all = moments.map((_, frame) => positions(frame));
  const extent = [0, 1, 2].map((c) => {
    const values = all.flatMap((r) => r[c]);
    return values.reduce((a, b) => Math.max(a, b)) - values.reduce((a, b) => Math.min(a, b));
  });
  return { nodes, fields, moments, positions, extent };
}
