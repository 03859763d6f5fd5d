// How a sheet looks: lit like paper so that folds cast shade, coloured by a field through a colour
// map, ruled with lines of equal a_1 and a_2. Colours are computed here to the end; three's own
// colour management is not used, so that screen and PNG agree.
import {
  Color,
  DataTexture,
  DoubleSide,
  LinearFilter,
  NearestFilter,
  RGBAFormat,
  ShaderMaterial,
  Vector2,
} from 'three';
import { colourTable, kMapSize } from './colormap';
import type { Scale } from './contract';

const kVertex = /* glsl */ `
  attribute vec2 parameter;
  attribute float value;
  attribute float known;
  varying vec2 vParameter;
  varying vec3 vNormal;
  varying vec3 vView;
  varying float vValue;
  varying float vKnown;
  flat varying float vLabel;

  void main() {
    vec4 eye = modelViewMatrix * vec4(position, 1.0);
    vParameter = parameter;
    vNormal = normalMatrix * normal;
    vView = -eye.xyz;
    vValue = value;
    vKnown = known;
    vLabel = value;
    gl_Position = projectionMatrix * eye;
  }`;

const kFragment = /* glsl */ `
  uniform sampler2D map;
  uniform vec2 range;
  uniform bool categorical;
  uniform vec3 plain;
  uniform vec2 origin;
  uniform vec2 spacing;
  uniform float lines;
  uniform vec3 ghostColour;
  uniform bool ghost;
  varying vec2 vParameter;
  varying vec3 vNormal;
  varying vec3 vView;
  varying float vValue;
  varying float vKnown;
  flat varying float vLabel;

  // How much of the pixel is on a line, of lines about 1.3 pixels wide.
  float ruled() {
    vec2 cell = (vParameter - origin) / spacing;
    vec2 width = fwidth(cell) + 1e-6;
    vec2 toLine = abs(fract(cell - 0.5) - 0.5) / width;
    vec2 line = 1.0 - smoothstep(0.25, 1.15, toLine);
    // Lines closer than a few pixels would be a grey haze.
    line *= 1.0 - smoothstep(0.1, 0.36, width);
    return max(line.x, line.y);
  }

  vec3 linear(vec3 c) { return pow(c, vec3(2.2)); }

  void main() {
    if (ghost) {
      float line = ruled();
      if (line < 0.15) discard;
      gl_FragColor = vec4(ghostColour, 0.85 * line);
      return;
    }
    vec3 view = normalize(vView);
    vec3 n = normalize(vNormal);
    if (dot(n, view) < 0.0) n = -n;

    float t = categorical ? (vLabel + 0.5) / ${kMapSize}.0
                          : clamp((vValue - range.x) / (range.y - range.x), 0.0, 1.0)
                                * ${kMapSize - 1}.0 / ${kMapSize}.0 + 0.5 / ${kMapSize}.0;
    vec3 base = vKnown > 0.999 ? texture2D(map, vec2(t, 0.5)).rgb : plain;
    // The sheet's underside is cooler and darker: where it shows, the sheet has folded over.
    if (!gl_FrontFacing) base = mix(base, vec3(0.42, 0.50, 0.60), 0.42);

    vec3 key = normalize(vec3(-0.62, 0.62, 0.48));
    vec3 fill = normalize(vec3(0.75, 0.1, 0.55));
    float keyLight = max(dot(n, key), 0.0);
    float light = 0.16 + 0.88 * keyLight + 0.16 * max(dot(n, fill), 0.0)
                + 0.08 * max(dot(n, view), 0.0);
    vec3 colour = linear(base) * light;
    float shine = pow(max(dot(n, normalize(key + view)), 0.0), 40.0);
    colour += 0.05 * shine;
    colour = pow(clamp(colour, 0.0, 1.0), vec3(1.0 / 2.2));
    colour = mix(colour, colour * 0.38, lines * ruled());
    gl_FragColor = vec4(colour, 1.0);
  }`;

function mapTexture(scale: Scale): DataTexture {
  const bytes = new Uint8Array(4 * kMapSize);
  colourTable(scale).forEach((rgb, i) => {
    bytes.set([...rgb.map((x) => Math.round(255 * x)), 255], 4 * i);
  });
  const texture = new DataTexture(bytes, kMapSize, 1, RGBAFormat);
  const filter = scale === 'categorical' ? NearestFilter : LinearFilter;
  texture.minFilter = filter;
  texture.magFilter = filter;
  texture.needsUpdate = true;
  return texture;
}

/** How dark the ruled lines are. */
const kLines = 0.42;

export class SurfaceMaterial extends ShaderMaterial {
  private readonly maps: Record<Scale, DataTexture>;

  /** Lines start at `origin` and are `spacing` apart, both in (a_1, a_2). */
  constructor(origin: [number, number], spacing: [number, number]) {
    const maps = {
      sequential: mapTexture('sequential'),
      diverging: mapTexture('diverging'),
      categorical: mapTexture('categorical'),
    };
    super({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      side: DoubleSide,
      uniforms: {
        map: { value: maps.sequential },
        range: { value: new Vector2(0, 1) },
        categorical: { value: false },
        plain: { value: new Color().setRGB(0.955, 0.94, 0.905) },
        origin: { value: new Vector2(...origin) },
        spacing: { value: new Vector2(...spacing) },
        lines: { value: kLines },
        ghost: { value: false },
        ghostColour: { value: new Color() },
      },
    });
    this.maps = maps;
  }

  setField(scale: Scale, low: number, high: number): void {
    this.uniforms.map.value = this.maps[scale];
    this.uniforms.categorical.value = scale === 'categorical';
    (this.uniforms.range.value as Vector2).set(low, high);
  }

  setLines(on: boolean): void {
    this.uniforms.lines.value = on ? kLines : 0;
  }

  /** The same lines alone, without the sheet, in `rgb` (0 … 1). */
  makeGhost(rgb: number[]): void {
    this.uniforms.ghost.value = true;
    this.transparent = true;
    this.depthWrite = false;
    this.polygonOffset = true;
    this.polygonOffsetFactor = -1;
    this.polygonOffsetUnits = -2;
    this.setGhostColour(rgb);
  }

  setGhostColour(rgb: number[]): void {
    (this.uniforms.ghostColour.value as Color).setRGB(rgb[0], rgb[1], rgb[2]);
  }
}
