// Arrays that travel as base64 text. One frame is decoded at a time, when it is shown, so that a
// page of 60 MB opens at once. Browsers run on little-endian machines only; the data is, too.

/** Quantised values are min + (max − min) level / 65534; level 65535 says that there is none. */
export const kLevels = 65534;
export const kMissing = 65535;

type FromBase64 = { fromBase64?: (text: string) => Uint8Array };

function decode(text: string): Uint8Array {
  const native = (Uint8Array as FromBase64).fromBase64;
  if (native) return native.call(Uint8Array, text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Bytes `first` … `first + count` of what `text` encodes, at an address that suits any type. */
function decodePart(text: string, first: number, count: number): ArrayBuffer {
  // Three bytes are four characters.
  const group = Math.floor(first / 3);
  const bytes = decode(text.slice(4 * group, 4 * Math.ceil((first + count) / 3)));
  const start = first - 3 * group;
  if (bytes.length < start + count) throw new Error('an array of the report is too short');
  return bytes.slice(start, start + count).buffer as ArrayBuffer;
}

export function decodeUint32(text: string): Uint32Array {
  const bytes = decode(text);
  return new Uint32Array(bytes.slice(0, bytes.length & ~3).buffer);
}

export function decodeFloat32(text: string): Float32Array {
  const bytes = decode(text);
  return new Float32Array(bytes.slice(0, bytes.length & ~3).buffer);
}

/** Frames of `size` uint16 levels each. */
export class LevelFrames {
  private cache = new Map<number, Uint16Array>();

  constructor(
    private readonly text: string,
    private readonly size: number,
  ) {}

  frame(i: number): Uint16Array {
    let levels = this.cache.get(i);
    if (!levels) {
      levels = new Uint16Array(decodePart(this.text, 2 * this.size * i, 2 * this.size));
      // Playing needs two neighbouring frames; more would only fill memory.
      if (this.cache.size >= 2) this.cache.delete(this.cache.keys().next().value!);
      this.cache.set(i, levels);
    }
    return levels;
  }
}
