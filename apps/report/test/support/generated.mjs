// Reports with known content, of any size: variant i is a wave of amplitude 0.05 (i + 1) t m.
const kLevels = 65534;

export function base64(array) {
  return Buffer.from(array.buffer, array.byteOffset, array.byteLength).toString('base64');
}

function mesh(side) {
  const parameters = new Float32Array(2 * side * side);
  const quads = new Uint32Array(4 * (side - 1) * (side - 1));
  let q = 0;
  for (let j = 0; j < side; ++j) {
    for (let i = 0; i < side; ++i) {
      const k = j * side + i;
      parameters.set([i / (side - 1), j / (side - 1)], 2 * k);
      if (i + 1 < side && j + 1 < side) {
        quads.set([k, k + 1, k + side + 1, k + side], q);
        q += 4;
      }
    }
  }
  return { parameters, quads };
}

/** The height of node (a, b) in variant i at time t. */
export function height(i, t, a, b) {
  return 0.05 * (i + 1) * t * Math.sin(Math.PI * a) * Math.sin(2 * Math.PI * b);
}

function positions(i, frames, times, parameters) {
  const nodes = parameters.length / 2;
  const limit = 0.05 * (i + 1) * times.at(-1);
  const data = new Uint16Array(3 * nodes * frames);
  for (let f = 0; f < frames; ++f) {
    for (let k = 0; k < nodes; ++k) {
      const [a, b] = parameters.subarray(2 * k, 2 * k + 2);
      const z = (height(i, times[f], a, b) + limit) / (2 * limit);
      data.set([a, b, z].map((x) => Math.round(x * kLevels)), 3 * (f * nodes + k));
    }
  }
  return { min: [0, 0, -limit], max: [1, 1, limit], data: base64(data) };
}

function fields(frames, parameters) {
  const nodes = parameters.length / 2;
  const slope = new Uint16Array(frames * nodes);
  const branch = new Uint16Array(frames * nodes);
  for (let f = 0; f < frames; ++f) {
    for (let k = 0; k < nodes; ++k) {
      // The first node has no slope: the page must cope with a value that is missing.
      slope[f * nodes + k] = k === 0 ? 65535 : Math.round(parameters[2 * k] * kLevels);
      branch[f * nodes + k] = Math.floor(parameters[2 * k + 1] * 2.999);
    }
  }
  const labels = ['at rest', 'B above delta', 'B below delta'];
  const kinds = { name: 'branch', unit: '', scale: 'categorical', labels };
  return [
    { name: 'B_11', unit: '1/m', scale: 'diverging', min: -2, max: 6, data: base64(slope) },
    { ...kinds, min: 0, max: 2, data: base64(branch) },
  ];
}

/**
 * A report of `count` variants. The first is the reference; `diverged` ends at half time; `parted`
 * leaves the reference at the third frame. Both are indices.
 */
export function makeReport({
  count = 3,
  side = 9,
  frames = 11,
  diverged = -1,
  parted = -1,
  withFields = true,
}) {
  const { parameters, quads } = mesh(side);
  const times = Array.from({ length: frames }, (_, f) => f / (frames - 1));
  const steps = times.map((_, f) => 5 * f);
  const variants = Array.from({ length: count }, (_, i) => {
    const reached = i === diverged ? Math.ceil(frames / 2) : frames;
    return {
      name: count === 1 ? 'base' : `variant ${i}, xi=1e-${i % 9}`,
      status: i === diverged ? 'diverged' : 'done',
      reason: i === diverged ? 'node 4 is 12 m away (step 26, bending)' : '',
      frames: reached,
      positions: positions(i, reached, times, parameters),
      fields: withFields ? fields(reached, parameters) : [],
      probes: {
        columns: [
          { name: 'step', unit: '' },
          { name: 'time', unit: 's' },
          { name: 'energy', unit: 'J' },
          { name: 'lowest', unit: 'm' },
        ],
        rows: times
          .slice(0, reached)
          .map((t, f) => [steps[f], t, (i + 1) * t ** 2, -0.05 * (i + 1) * t]),
      },
      changes: i === 0 ? [] : [{ pointer: '/energies/0/xi', value: 10 ** -(i % 9) }],
      cost: { ms_per_step: 1 + i / 10, peak_memory_MB: 30, iterations: null },
      parts: i === parted ? { step: 10, time: times[2], where: [0.5, 0.5], node: 40 } : null,
      manifest: { program: 'deform', steps: 50 },
    };
  });
  const single = count === 1;
  return {
    format: 1,
    kind: single ? 'run' : 'comparison',
    title: 'Generated </script><b>report</b>',
    created: '2024-01-01T00:00:00Z',
    program: 'deform 0.1.0',
    mesh: { nodes: side * side, quads: base64(quads), parameters: base64(parameters) },
    frames: { steps, times },
    reference: single ? null : variants[0].name,
    tolerance: single ? null : { value: 0.01, unit: 'm' },
    variants,
    verdict: single
      ? null
      : {
          columns: [{ name: 'largest distance', unit: 'm', better: 'lower' }],
          rows: variants.map((v, i) => ({ variant: v.name, values: [i === 0 ? null : 0.05 * i] })),
          sentences: ['variant 1 is nearest.', 'The others are not.'],
        },
    scene: { title: 'generated' },
    notes: ['made by a test'],
  };
}
