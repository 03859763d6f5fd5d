// The faces that all variants share, and what can be measured on them.
import { decodeFloat32, decodeUint32 } from './blocks';
import type { ReportData } from './contract';

/** Edges that bend by more than this count as creased. */
export const kCreaseDegrees = 30;

export class Mesh {
  readonly nodes: number;
  /** Triangles, three nodes each; a quad is cut in two. */
  readonly triangles: Uint32Array;
  /** (a_1, a_2) of each node, or null. */
  readonly parameters: Float32Array | null;
  private readonly numbers: Uint32Array | null;
  private readonly corners: Uint32Array;
  private readonly cornersPerFace: number;
  private edges: Uint32Array | null = null;

  constructor(data: ReportData['mesh']) {
    this.nodes = data.nodes;
    this.cornersPerFace = data.quads !== undefined ? 4 : 3;
    this.corners = decodeUint32(data.quads ?? data.triangles ?? '');
    this.triangles = data.quads !== undefined ? split(this.corners) : this.corners;
    this.parameters = data.parameters ? decodeFloat32(data.parameters) : null;
    this.numbers = data.numbers ? decodeUint32(data.numbers) : null;
  }

  /** The simulation's number of a shown node. */
  number(node: number): number {
    return this.numbers ? this.numbers[node] : node;
  }

  /** Unit normals at the nodes: area-weighted means of the faces' normals. */
  normals(r: Float32Array, normals: Float32Array): void {
    normals.fill(0);
    const t = this.triangles;
    for (let i = 0; i < t.length; i += 3) {
      const a = 3 * t[i];
      const b = 3 * t[i + 1];
      const c = 3 * t[i + 2];
      const ux = r[b] - r[a];
      const uy = r[b + 1] - r[a + 1];
      const uz = r[b + 2] - r[a + 2];
      const vx = r[c] - r[a];
      const vy = r[c + 1] - r[a + 1];
      const vz = r[c + 2] - r[a + 2];
      const nx = uy * vz - uz * vy;
      const ny = uz * vx - ux * vz;
      const nz = ux * vy - uy * vx;
      for (const k of [a, b, c]) {
        normals[k] += nx;
        normals[k + 1] += ny;
        normals[k + 2] += nz;
      }
    }
    for (let k = 0; k < normals.length; k += 3) {
      const length = Math.hypot(normals[k], normals[k + 1], normals[k + 2]) || 1;
      normals[k] /= length;
      normals[k + 1] /= length;
      normals[k + 2] /= length;
    }
  }

  /** The share of inner edges at which the faces on both sides differ by more than 30 degrees. */
  creasedShare(r: Float32Array): number {
    const n = this.faceNormals(r);
    const edges = (this.edges ??= innerEdges(this.corners, this.cornersPerFace));
    const limit = Math.cos((kCreaseDegrees * Math.PI) / 180);
    let creased = 0;
    for (let e = 0; e < edges.length; e += 2) {
      const a = 3 * edges[e];
      const b = 3 * edges[e + 1];
      if (n[a] * n[b] + n[a + 1] * n[b + 1] + n[a + 2] * n[b + 2] < limit) ++creased;
    }
    return edges.length > 0 ? (2 * creased) / edges.length : 0;
  }

  /** Unit normals of the faces; of a quad, the product of its diagonals. */
  private faceNormals(r: Float32Array): Float32Array {
    const size = this.cornersPerFace;
    const normals = new Float32Array((3 * this.corners.length) / size);
    for (let f = 0, i = 0; i < this.corners.length; f += 3, i += size) {
      const [from, to] = size === 4 ? [i + 1, i + 3] : [i, i + 2];
      const a = 3 * this.corners[i];
      const c = 3 * this.corners[size === 4 ? i + 2 : i + 1];
      const b = 3 * this.corners[from];
      const d = 3 * this.corners[to];
      const ux = r[c] - r[a];
      const uy = r[c + 1] - r[a + 1];
      const uz = r[c + 2] - r[a + 2];
      const vx = r[d] - r[b];
      const vy = r[d + 1] - r[b + 1];
      const vz = r[d + 2] - r[b + 2];
      const x = uy * vz - uz * vy;
      const y = uz * vx - ux * vz;
      const z = ux * vy - uy * vx;
      const length = Math.hypot(x, y, z) || 1;
      normals[f] = x / length;
      normals[f + 1] = y / length;
      normals[f + 2] = z / length;
    }
    return normals;
  }
}

function split(quads: Uint32Array): Uint32Array {
  const triangles = new Uint32Array((quads.length / 4) * 6);
  for (let q = 0, t = 0; q < quads.length; q += 4, t += 6) {
    const [a, b, c, d] = quads.subarray(q, q + 4);
    triangles.set([a, b, c, a, c, d], t);
  }
  return triangles;
}

/** The two faces at each edge that has two, in pairs. */
function innerEdges(corners: Uint32Array, size: number): Uint32Array {
  const faceAt = new Map<number, number>();
  const pairs: number[] = [];
  for (let i = 0; i < corners.length; ++i) {
    const face = Math.floor(i / size);
    const a = corners[i];
    const b = corners[face * size + ((i + 1) % size)];
    const key = Math.min(a, b) * 2 ** 26 + Math.max(a, b);
    const other = faceAt.get(key);
    if (other === undefined) faceAt.set(key, face);
    else pairs.push(other, face);
  }
  return Uint32Array.from(pairs);
}
