// The one camera that all tiles share.
import { PerspectiveCamera, Vector3 } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import type { NamedCamera, ViewStore } from './view';

const kDirections: Record<NamedCamera, Vector3> = {
  fit: new Vector3(-0.52, -1, 0.95).normalize(),
  top: new Vector3(0, -1e-4, 1).normalize(),
  front: new Vector3(0, -1, 0.02).normalize(),
  side: new Vector3(1, 0, 0.02).normalize(),
};

export class SharedCamera {
  readonly camera = new PerspectiveCamera(26, 1, 0.01, 100);
  private readonly controls: OrbitControls;
  private outline: Vector3[] = [];

  /** Listens on `stage`; `onChange` is called whenever the picture has to be drawn again. */
  constructor(
    stage: HTMLElement,
    private readonly view: ViewStore,
    onChange: () => void,
  ) {
    this.camera.up.set(0, 0, 1);
    // The wheel scrolls the page, as everywhere; with Ctrl, or pinching, it zooms.
    stage.addEventListener(
      'wheel',
      (event) => {
        if (!event.ctrlKey && !event.metaKey) event.stopImmediatePropagation();
      },
      { capture: true },
    );
    this.controls = new OrbitControls(this.camera, stage);
    this.controls.enableDamping = false;
    // One finger moved up or down scrolls the page; sideways, or two fingers, moves the camera.
    stage.style.touchAction = 'pan-y';
    this.controls.addEventListener('start', () => this.view.set({ camera: 'free' }));
    this.controls.addEventListener('change', onChange);
  }

  /** The points that `fit` and the other views show. */
  setOutline(points: number[][], exaggeration: number): void {
    this.outline = points.map(([x, y, z]) => new Vector3(x, y, z * exaggeration));
  }

  setAspect(aspect: number): void {
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
  }

  /** Looks from a named side, so near that the outline fills these parts of width and height. */
  look(name: NamedCamera, fill: { x: number; y: number }): void {
    const direction = kDirections[name];
    const right = new Vector3(0, 0, 1).cross(direction).normalize();
    const up = direction.clone().cross(right);
    const tan = Math.tan((this.camera.fov * Math.PI) / 360);
    const half = { x: tan * this.camera.aspect * fill.x, y: tan * fill.y };
    const target = this.outline
      .reduce((sum, p) => sum.add(p), new Vector3())
      .divideScalar(Math.max(this.outline.length, 1));
    let distance = 1;
    // What is near looks large, so that the middle of the picture is found step by step.
    for (let round = 0; round < 5; ++round) {
      const local = this.outline.map((point) => {
        const p = point.clone().sub(target);
        return { x: p.dot(right), y: p.dot(up), toward: p.dot(direction) };
      });
      const needed = local.map((p) =>
        Math.max(p.toward + Math.abs(p.x) / half.x, p.toward + Math.abs(p.y) / half.y),
      );
      distance = Math.max(1e-9, ...needed);
      const middle = (values: number[]) => (Math.min(...values) + Math.max(...values)) / 2;
      target
        .addScaledVector(right, distance * middle(local.map((p) => p.x / (distance - p.toward))))
        .addScaledVector(up, distance * middle(local.map((p) => p.y / (distance - p.toward))));
    }
    this.place(target.clone().addScaledVector(direction, distance * 1.01), target);
  }

  /** Position and target, six numbers, as `#camera=` holds them. */
  get free(): number[] {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()];
  }

  setFree(numbers: number[]): void {
    const [x, y, z, tx, ty, tz] = numbers;
    this.place(new Vector3(x, y, z), new Vector3(tx, ty, tz));
  }

  private place(position: Vector3, target: Vector3): void {
    const distance = position.distanceTo(target);
    this.camera.near = distance / 100;
    this.camera.far = distance * 20;
    this.camera.updateProjectionMatrix();
    this.camera.position.copy(position);
    this.controls.target.copy(target);
    this.controls.update();
  }
}
