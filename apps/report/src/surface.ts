// The sheet of one variant as a mesh on the graphics card.
import {
  BufferAttribute,
  BufferGeometry,
  DynamicDrawUsage,
  Mesh as ThreeMesh,
  Sphere,
  Vector3,
} from 'three';
import type { Fields } from './fields';
import type { Mesh } from './mesh';
import type { SurfaceMaterial } from './surface_material';
import type { Variant } from './variant';

/** What every sheet shares: faces and parameters lie on the card once. */
export class SharedGeometry {
  readonly index: BufferAttribute;
  readonly parameter: BufferAttribute;

  constructor(readonly mesh: Mesh) {
    this.index = new BufferAttribute(mesh.triangles, 1);
    this.parameter = new BufferAttribute(
      mesh.parameters ?? new Float32Array(2 * mesh.nodes).fill(0.5),
      2,
    );
  }
}

export class Surface {
  readonly object: ThreeMesh<BufferGeometry, SurfaceMaterial>;
  readonly r: Float32Array;
  private readonly normals: BufferAttribute;
  private readonly positions: BufferAttribute;
  private readonly value: BufferAttribute;
  private readonly known: BufferAttribute;
  private shownAt = -1;
  private shownField = '';

  constructor(
    readonly variant: Variant,
    private readonly shared: SharedGeometry,
    material: SurfaceMaterial,
  ) {
    const nodes = shared.mesh.nodes;
    const attribute = (size: number) => {
      const a = new BufferAttribute(new Float32Array(size * nodes), size);
      a.setUsage(DynamicDrawUsage);
      return a;
    };
    this.positions = attribute(3);
    this.normals = attribute(3);
    this.value = attribute(1);
    this.known = attribute(1);
    this.r = this.positions.array as Float32Array;
    const geometry = new BufferGeometry();
    geometry.setIndex(shared.index);
    geometry.setAttribute('position', this.positions);
    geometry.setAttribute('normal', this.normals);
    geometry.setAttribute('parameter', shared.parameter);
    geometry.setAttribute('value', this.value);
    geometry.setAttribute('known', this.known);
    geometry.boundingSphere = new Sphere(new Vector3(), Infinity);
    this.object = new ThreeMesh(geometry, material);
    this.object.frustumCulled = false;
    this.object.visible = false;
  }

  /** Brings shape and colours to a moment; does nothing if they are there already. */
  show(at: number, fields: Fields, field: string): void {
    const frame = this.variant.shownFrame(at);
    if (frame !== this.shownAt) {
      this.variant.positionsAt(frame, this.r);
      this.shared.mesh.normals(this.r, this.normals.array as Float32Array);
      this.positions.needsUpdate = true;
      this.normals.needsUpdate = true;
    }
    if (frame !== this.shownAt || field !== this.shownField) this.colour(frame, fields, field);
    this.shownAt = frame;
    this.shownField = field;
  }

  /** The field's value at a node; NaN if it has none. */
  valueAt(node: number): number {
    return this.known.array[node] > 0 ? this.value.array[node] : NaN;
  }

  private colour(frame: number, fields: Fields, field: string): void {
    const values = this.value.array as Float32Array;
    const known = this.known.array as Float32Array;
    if (fields.values(field, this.variant, frame, values)) {
      for (let k = 0; k < values.length; ++k) {
        known[k] = Number.isNaN(values[k]) ? 0 : 1;
        if (known[k] === 0) values[k] = 0;
      }
    } else {
      known.fill(0);
    }
    this.value.needsUpdate = true;
    this.known.needsUpdate = true;
  }
}
