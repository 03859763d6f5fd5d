// Draws variants: each into its part of one canvas, or into a picture of its own.
import {
  BufferAttribute,
  BufferGeometry,
  ColorManagement,
  LinearSRGBColorSpace,
  Points,
  PointsMaterial,
  Raycaster,
  Scene,
  Vector2,
  WebGLRenderer,
  WebGLRenderTarget,
  type PerspectiveCamera,
} from 'three';
import { fromCss } from './colour';
import type { Fields } from './fields';
import type { Report } from './report';
import { SharedGeometry, Surface } from './surface';
import { SurfaceMaterial } from './surface_material';
import { themeColour } from './theme';
import type { Variant } from './variant';
import type { View } from './view';

/** A part of the canvas, in CSS pixels from its upper left corner. */
export interface Rectangle {
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface Hit {
  node: number;
  value: number;
}

export class Renderer {
  private readonly gl: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly material: SurfaceMaterial;
  private readonly ghostMaterial: SurfaceMaterial;
  private readonly surfaces = new Map<Variant, Surface>();
  private readonly shared: SharedGeometry;
  private readonly ghost: Surface | null;
  private readonly mark: Points;
  private height = 1;

  constructor(
    canvas: HTMLCanvasElement,
    report: Report,
    private readonly fields: Fields,
  ) {
    // Colours are what the style sheet says; nobody converts them on the way.
    ColorManagement.enabled = false;
    this.gl = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.gl.outputColorSpace = LinearSRGBColorSpace;
    this.gl.setClearColor(0x000000, 0);
    this.gl.autoClear = false;
    this.shared = new SharedGeometry(report.mesh);
    const { origin, spacing } = ruling(report);
    this.material = new SurfaceMaterial(origin, spacing);
    this.ghostMaterial = new SurfaceMaterial(origin, spacing);
    this.ghostMaterial.makeGhost([0, 0, 0]);
    const { reference } = report;
    this.ghost = reference?.hasShape
      ? new Surface(reference, this.shared, this.ghostMaterial)
      : null;
    if (this.ghost) this.scene.add(this.ghost.object);
    this.mark = new Points(
      new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(3), 3)),
      new PointsMaterial({ size: 9, sizeAttenuation: false, depthTest: false, transparent: true }),
    );
    this.mark.frustumCulled = false;
    this.mark.visible = false;
    this.scene.add(this.mark);
    this.applyTheme();
  }

  applyTheme(): void {
    this.ghostMaterial.setGhostColour(fromCss(themeColour('--ghost')));
    (this.mark.material as PointsMaterial).color.set(themeColour('--accent'));
  }

  resize(width: number, height: number): void {
    this.height = height;
    this.gl.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.gl.setSize(width, height, false);
  }

  clear(): void {
    this.gl.setScissorTest(false);
    this.gl.clear();
  }

  /** Draws a variant as `view` wants it; `marked` is a node to point at, or null. */
  draw(
    variant: Variant,
    part: Rectangle,
    camera: PerspectiveCamera,
    view: View,
    marked: number | null,
  ): void {
    const bottom = this.height - part.y - part.height;
    this.gl.setViewport(part.x, bottom, part.width, part.height);
    this.gl.setScissor(part.x, bottom, part.width, part.height);
    this.gl.setScissorTest(true);
    this.render(variant, camera, view, marked);
  }

  /** A picture of a variant on a plain background, for a contact sheet. */
  picture(
    variant: Variant,
    size: { width: number; height: number },
    camera: PerspectiveCamera,
    view: View,
    background: string,
  ): ImageData {
    const { width, height } = size;
    const target = new WebGLRenderTarget(width, height, { samples: 4 });
    const pixels = new Uint8Array(4 * width * height);
    this.gl.setRenderTarget(target);
    this.gl.setClearColor(background, 1);
    this.gl.clear();
    this.render(variant, camera, view, null);
    this.gl.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    this.gl.setRenderTarget(null);
    this.gl.setClearColor(0x000000, 0);
    target.dispose();
    const image = new ImageData(width, height);
    const row = 4 * width;
    for (let y = 0; y < height; ++y) {
      image.data.set(pixels.subarray(row * (height - 1 - y), row * (height - y)), row * y);
    }
    return image;
  }

  /** The node nearest to where a ray through `point` (−1 … 1) meets a variant that is drawn. */
  pick(variant: Variant, point: { x: number; y: number }, camera: PerspectiveCamera): Hit | null {
    const surface = this.surfaces.get(variant);
    if (!surface) return null;
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2(point.x, point.y), camera);
    surface.object.visible = true;
    const hit = ray.intersectObject(surface.object, false)[0];
    surface.object.visible = false;
    if (!hit?.face) return null;
    const p = surface.object.worldToLocal(hit.point.clone());
    const distance = (node: number) =>
      Math.hypot(...[p.x, p.y, p.z].map((x, c) => x - surface.r[3 * node + c]));
    const { a, b, c } = hit.face;
    const node = [a, b, c].reduce((best, i) => (distance(i) < distance(best) ? i : best));
    return { node, value: surface.valueAt(node) };
  }

  /** Positions of a variant as last drawn, nodes × 3, or null. */
  shownPositions(variant: Variant): Float32Array | null {
    return this.surfaces.get(variant)?.r ?? null;
  }

  private render(
    variant: Variant,
    camera: PerspectiveCamera,
    view: View,
    marked: number | null,
  ): void {
    const surface = this.surface(variant);
    const field = this.fields.find(view.field);
    const range = this.fields.range(view.field, view.clip);
    this.material.setField(field?.scale ?? 'sequential', range.low, range.high);
    this.material.setLines(view.lines);
    surface.show(view.at, this.fields, view.field);
    this.place(surface, view);
    surface.object.visible = true;
    const ghost = view.ghost && !variant.isReference ? this.ghost : null;
    if (ghost) {
      ghost.show(Math.min(view.at, variant.shownFrame(view.at)), this.fields, '');
      this.place(ghost, view);
      ghost.object.visible = true;
    }
    if (marked !== null) {
      const [x, y, z] = surface.r.subarray(3 * marked, 3 * marked + 3);
      this.mark.position.set(x, y, z * view.exaggeration);
      this.mark.visible = true;
    }
    this.gl.render(this.scene, camera);
    surface.object.visible = false;
    if (ghost) ghost.object.visible = false;
    this.mark.visible = false;
  }

  private place(surface: Surface, view: View): void {
    surface.object.scale.z = view.exaggeration;
    surface.object.updateMatrixWorld();
  }

  private surface(variant: Variant): Surface {
    let surface = this.surfaces.get(variant);
    if (!surface) {
      surface = new Surface(variant, this.shared, this.material);
      this.surfaces.set(variant, surface);
      this.scene.add(surface.object);
    }
    return surface;
  }
}

/** Where to rule the sheet: on the mesh's own lines if they are few, else about 24 a side. */
function ruling(report: Report): { origin: [number, number]; spacing: [number, number] } {
  const { parameters, nodes } = report.mesh;
  // Without parameters no line is ever met: they are constant, half a cell from the origin.
  if (!parameters) return { origin: [0, 0], spacing: [1, 1] };
  const axis = (c: number) => {
    const values = new Set<number>();
    let low = Infinity;
    let high = -Infinity;
    for (let k = 0; k < nodes; ++k) {
      const a = parameters[2 * k + c];
      low = Math.min(low, a);
      high = Math.max(high, a);
      if (values.size < 64) values.add(a);
    }
    const cells = values.size - 1;
    return { low, span: high - low || 1, cells: cells <= 40 ? Math.max(cells, 1) : 0 };
  };
  const axes = [axis(0), axis(1)];
  const longest = Math.max(axes[0].span, axes[1].span);
  const spacing = axes.map(({ span, cells }) =>
    cells > 0 ? span / cells : span / Math.max(1, Math.round((24 * span) / longest)),
  );
  return { origin: [axes[0].low, axes[1].low], spacing: [spacing[0], spacing[1]] };
}
