// The built page in a real browser, from file://, with reports of known content.
// Needs `npm run build` before, and Chromium.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { embed } from '../scripts/embed.mjs';
import { launch, open } from './support/browser.mjs';
import { base64, height, makeReport } from './support/generated.mjs';
import { different, readPng } from './support/picture.mjs';

const kTemplate = process.env.DEFORM_REPORT_PAGE
  ? pathToFileURL(process.env.DEFORM_REPORT_PAGE)
  : new URL('../dist/report.html', import.meta.url);
let browser;
let folder;

before(async () => {
  browser = await launch();
  folder = mkdtempSync(join(tmpdir(), 'deform-report-'));
});

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

let pages = 0;
/** A report as a file; its URL. */
function file(report) {
  const path = join(folder, `${++pages}.html`);
  writeFileSync(path, embed(readFileSync(kTemplate, 'utf8'), JSON.stringify(report)));
  return pathToFileURL(path).href;
}

/** What the part of the page that `selector` names looks like, as pixels. */
async function look(page, selector) {
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => done())));
  return readPng(await page.locator(selector).first().screenshot());
}

/** Runs `act` on an open page, which must have done nothing that it must not. */
async function onPage(report, act, { hash = '', ...options } = {}) {
  const page = await open(browser, file(report) + hash, options);
  try {
    await act(page);
    assert.deepEqual(page.trouble, []);
  } finally {
    await page.context().close();
  }
}

test('the template has one placeholder and says that it holds no report', async () => {
  const text = readFileSync(kTemplate, 'utf8');
  const placeholder = '<script id="deform-data" type="application/json">null</script>';
  assert.equal(text.split(placeholder).length, 2);
  assert.ok(!/<(script|link|img)[^>]*(src|href)="(?!data:)/.test(text), 'all is inside the file');
  const page = await (await browser.newContext()).newPage();
  await page.goto(kTemplate.href);
  assert.match(await page.locator('.failure').innerText(), /holds no report/);
  await assert.rejects(page.evaluate(() => window.deformReport.ready));
  await page.context().close();
});

test('an unknown format is refused in words', async () => {
  const page = await (await browser.newContext()).newPage();
  await page.goto(file({ ...makeReport({}), format: 2 }));
  assert.match(await page.locator('.failure').innerText(), /format 1.*format 2/);
  await page.context().close();
});

test('one, three and sixty variants are shown', async () => {
  for (const [count, visible] of [[1, 1], [3, 3], [60, null]]) {
    await onPage(makeReport({ count }), async (page) => {
      const tiles = await page.locator('.tile:visible').count();
      if (visible === null) {
        assert.ok(tiles >= 20 && tiles < 60, `${tiles} of 60 on the first page`);
        await page.getByRole('button', { name: 'Next page' }).click();
        assert.match(await page.locator('.pager').innerText(), /–60 of 60 variants/);
      } else {
        assert.equal(tiles, visible);
      }
      for (const tile of await page.locator('.tile:visible').all()) {
        const { colours } = readPng(await tile.screenshot());
        assert.ok(colours > 50, 'a sheet is drawn in every tile');
      }
    });
  }
});

test('the slider moves nodes and changes the picture', async () => {
  await onPage(makeReport({ count: 3, side: 9, frames: 11 }), async (page) => {
    const node = 4 * 9 + 4 - 18; // a = 0.5, b = 0.25: the crest
    const name = 'variant 2, xi=1e-2';
    const z = () => page.evaluate(([n, k]) => deformReport.position(n, k)[2], [name, node]);
    assert.ok(Math.abs((await z()) - height(2, 1, 0.5, 0.25)) < 1e-5, 'the end is shown first');
    const late = await look(page, '.surface');
    const slider = page.getByRole('slider', { name: 'Time' });
    await slider.fill('2');
    const early = await look(page, '.surface');
    assert.ok(Math.abs((await z()) - height(2, 0.2, 0.5, 0.25)) < 1e-5);
    assert.ok(different(early, late) > 0.01);
    assert.match(await slider.getAttribute('aria-valuetext'), /0.2 seconds, step 10/);
    await page.keyboard.press('ArrowRight');
    assert.equal(await slider.inputValue(), '3');
    await page.keyboard.press('Home');
    assert.equal(await slider.inputValue(), '0');
  });
});

test('play runs to the end and stops there', async () => {
  await onPage(makeReport({ count: 1 }), async (page) => {
    await page.evaluate(() => deformReport.setTime(9));
    await page.keyboard.press('Space');
    await page.getByRole('button', { name: 'Pause' }).waitFor();
    await page.getByRole('button', { name: 'Play' }).waitFor({ timeout: 20000 });
    assert.equal(await page.getByRole('slider').inputValue(), '10');
    await page.keyboard.press('Space');
    await page.waitForTimeout(400);
    await page.keyboard.press('Space');
    const at = Number(await page.getByRole('slider').inputValue());
    assert.ok(at < 10, 'from the end it begins again');
  });
});

test('a field changes colours and legend; every scale works', async () => {
  await onPage(makeReport({ count: 3 }), async (page) => {
    const first = await look(page, '.surface');
    assert.match(await page.locator('.legend').getAttribute('aria-label'), /distance to reference/);
    await page.getByLabel('Colour', { exact: true }).selectOption('B_11');
    const diverging = await look(page, '.surface');
    assert.ok(different(first, diverging) > 0.02);
    // 0.5 % of the nodes are cut at the upper end; zero is in the middle of a diverging scale.
    assert.match(await page.locator('.legend').getAttribute('aria-label'), /from −6 to 6/);
    await page.getByLabel('Colour', { exact: true }).selectOption('branch');
    assert.ok(different(diverging, await look(page, '.surface')) > 0.02);
    assert.match(await page.locator('.legend-labels').innerText(), /B above delta/);
    await page.getByLabel('Colour', { exact: true }).selectOption('plain paper');
    assert.equal(await page.locator('.legend *').count(), 0);
  });
});

test('a diverged variant keeps its last shape, with badge and reason', async () => {
  await onPage(makeReport({ count: 3, diverged: 1, parted: 2 }), async (page) => {
    const tile = page.locator('.tile[data-variant^="variant 1"]');
    assert.match(await tile.locator('.badge').innerText(), /diverged after 0.5 s/);
    assert.match(await tile.locator('.reason').innerText(), /node 4 is 12 m away/);
    const z = await page.evaluate(() => deformReport.position('variant 1, xi=1e-1', 22)[2]);
    assert.ok(Math.abs(z - height(1, 0.5, 0.5, 0.25)) < 1e-5);
    const parted = page.locator('.tile[data-variant^="variant 2"] .badge');
    assert.match(await parted.innerText(), /off since 0.2 s/);
    await page.evaluate(() => deformReport.setTime(1));
    assert.match(await parted.innerText(), /leaves at 0.2 s/);
    assert.match(await page.locator('.reasons').innerText(), /diverged: node 4/);
    assert.equal(await page.locator('.event').count(), 2);
  });
});

test('a variant that never had a shape does not stop the page', async () => {
  const report = makeReport({ count: 3 });
  const failed = { status: 'plugin failed', reason: 'normal mine threw', frames: 0, fields: [] };
  Object.assign(report.variants[2], failed, {
    positions: { min: [0, 0, 0], max: [0, 0, 0], data: '' },
    probes: { columns: [], rows: [] },
  });
  await onPage(report, async (page) => {
    const badge = page.locator('.tile[data-variant^="variant 2"] .badge');
    assert.match(await badge.innerText(), /plugin failed/);
    await page.evaluate(() => deformReport.contactSheet({ columns: [0], width: 100 }));
  });
});

test('triangles, missing parameters and renumbered nodes are shown', async () => {
  const report = makeReport({ count: 2 });
  const bytes = Buffer.from(report.mesh.quads, 'base64');
  const quads = new Uint32Array(new Uint8Array(bytes).buffer);
  const triangles = [];
  for (let q = 0; q < quads.length; q += 4) {
    const [a, b, c, d] = quads.subarray(q, q + 4);
    triangles.push(a, b, c, a, c, d);
  }
  const numbers = Uint32Array.from({ length: report.mesh.nodes }, (_, k) => 1000 + 2 * k);
  report.mesh = {
    nodes: report.mesh.nodes,
    triangles: base64(Uint32Array.from(triangles)),
    numbers: base64(numbers),
  };
  await onPage(report, async (page) => {
    const box = await page.locator('.tile').first().boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    const text = await page.locator('.tooltip').innerText();
    assert.match(text, /node\s+1\d\d\d/);
    assert.doesNotMatch(text, /parameter/);
  });
});

test('the ghost of the reference is drawn over the others', async () => {
  await onPage(makeReport({ count: 2 }), async (page) => {
    const [first, second] = ['.tile >> nth=0', '.tile >> nth=1'];
    const before = [await look(page, first), await look(page, second)];
    await page.getByLabel('reference ghost').check();
    assert.equal(different(before[0], await look(page, first)), 0, 'not over itself');
    assert.ok(different(before[1], await look(page, second)) > 0.01);
  });
});

test('plots draw, follow the slider, set the time, and can be logarithmic', async () => {
  await onPage(makeReport({ count: 3, diverged: 1 }), async (page) => {
    const plot = page.locator('.plot[data-probe="energy"]');
    await plot.scrollIntoViewIfNeeded();
    await plot.locator('canvas').waitFor();
    assert.equal(await page.locator('.plot').count(), 2);
    const linear = await look(page, '.plot[data-probe="energy"]');
    assert.ok(linear.colours > 30);
    const cursor = async () => (await plot.locator('.plot-cursor').boundingBox()).x;
    const late = await cursor();
    const area = await plot.locator('.u-over').boundingBox();
    await plot.locator('.u-over').click({ position: { x: area.width * 0.3, y: 60 } });
    assert.equal(await page.getByRole('slider').inputValue(), '3');
    assert.ok(Math.abs((late - (await cursor())) / area.width - 0.7) < 0.02);
    await plot.getByLabel('log').check();
    assert.ok(different(linear, await look(page, '.plot[data-probe="energy"]')) > 0.005);
  });
});

test('variants can be hidden, isolated and shown again', async () => {
  await onPage(makeReport({ count: 3 }), async (page) => {
    const visible = () => page.locator('.tile:visible').count();
    await page.locator('.chip').nth(1).click();
    assert.equal(await visible(), 2);
    assert.equal(await page.locator('.chip').nth(1).getAttribute('aria-pressed'), 'false');
    await page.getByRole('button', { name: 'show all' }).click();
    assert.equal(await visible(), 3);
    await page.locator('.tile').nth(2).click();
    assert.equal(await visible(), 1);
    await page.keyboard.press('Escape');
    assert.equal(await visible(), 3);
  });
});

test('dragging turns the camera; pointing names a node', async () => {
  await onPage(makeReport({ count: 3 }), async (page) => {
    const box = await page.locator('.tile').first().boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    const tooltip = page.locator('.tooltip');
    await tooltip.waitFor();
    assert.match(await tooltip.innerText(), /variant 0[^]*distance to reference[^]*parameter/);
    await page.mouse.move(5, 5);
    const before = await look(page, '.surface');
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 90, y + 10, { steps: 4 });
    await page.mouse.up();
    await page.mouse.move(5, 5);
    assert.ok(different(before, await look(page, '.surface')) > 0.02);
    assert.equal(await page.locator('.tile:visible').count(), 3, 'a drag is no click');
  });
});

test('the address sets the view and keeps it', async () => {
  const only = ['variant 0, xi=1e-0', 'variant 2, xi=1e-2'].map(encodeURIComponent).join(',');
  const hash = `#t=0.5&field=B_11&only=${only}&camera=top&z=2`;
  await onPage(
    makeReport({ count: 3 }),
    async (page) => {
      assert.equal(await page.getByRole('slider').inputValue(), '5');
      assert.equal(await page.locator('#field').inputValue(), 'B_11');
      assert.equal(await page.locator('.tile:visible').count(), 2);
      await page.evaluate(() => deformReport.setTime(7));
      await page.waitForFunction(() => location.hash.includes('t=0.7'));
      assert.match(await page.evaluate(() => location.hash), /camera=top.*z=2/);
      await page.evaluate(() => (location.hash = '#t=0.1&camera=1,1,2,0.5,0.5,0'));
      await page.waitForFunction(() => document.querySelector('.track input').value === '1');
    },
    { hash },
  );
});

test('the contact sheet is a picture of the right size, with something in every cell', async () => {
  await onPage(makeReport({ count: 3, diverged: 1 }), async (page) => {
    const url = await page.evaluate(() =>
      deformReport.contactSheet({ columns: [0, 5, 10], width: 200, height: 150 }),
    );
    const picture = readPng(Buffer.from(url.split(',')[1], 'base64'));
    assert.equal(picture.width, 95 + 3 * 200);
    assert.equal(picture.height, 20 + 3 * 150 + 42);
    for (let row = 0; row < 3; ++row) {
      for (let column = 0; column < 3; ++column) {
        const inked = picture.share(95 + 200 * column, 20 + 150 * row, 200, 150, 245);
        assert.ok(inked > 0.1, `cell ${row}, ${column}: ${inked}`);
      }
    }
    const before = await page.evaluate(() => deformReport.position('variant 2, xi=1e-2', 22)[2]);
    assert.ok(Math.abs(before - height(2, 1, 0.5, 0.25)) < 1e-5, 'the page shows what it showed');
    await assert.rejects(
      page.evaluate(() => deformReport.contactSheet({ columns: [11] })),
      /no frame 11; frames go from 0 to 10/,
    );
  });
});

test('the address asks for the contact sheet alone', async () => {
  await onPage(
    makeReport({ count: 2 }),
    async (page) => {
      const sheet = page.locator('#page > img#contact-sheet');
      await sheet.waitFor();
      const picture = readPng(Buffer.from((await sheet.getAttribute('src')).split(',')[1], 'base64'));
      assert.deepEqual([picture.width, picture.height], [190 + 5 * 400, 40 + 2 * 288 + 84]);
      assert.equal(await page.locator('#page > *').count(), 1);
    },
    { hash: '#contact-sheet=1' },
  );
});

test('variants without a shape, and a report without any, tell why', async () => {
  const report = makeReport({ count: 3 });
  const none = { frames: 0, positions: { min: [0, 0, 0], max: [0, 0, 0], data: '' }, fields: [] };
  const refused = { ...none, status: 'refused', reason: 'there is no normal plugin "gaus"' };
  Object.assign(report.variants[1], refused, { dropped: ['/energies/0/normal/delta'] });
  report.variants[2].not_measured = 'another surface';
  await onPage(report, async (page) => {
    assert.match(await page.locator('.reasons').innerText(), /refused: there is no normal plugin/);
    assert.match(await page.locator('.changes').innerText(), /dropped: no such parameter/);
    assert.match(await page.locator('.verdict').innerText(), /not measured/);
  });
  const mesh = { nodes: 0, triangles: '', parameters: '' };
  const empty = { ...report, mesh, frames: { steps: [], times: [] }, verdict: null };
  empty.variants = report.variants.map((v) => ({ ...v, ...refused, cost: null }));
  await onPage(empty, async (page) => {
    assert.equal(await page.locator('.reasons li').count(), 3);
  });
});

test('the verdict can be sorted and marks the best', async () => {
  await onPage(makeReport({ count: 3 }), async (page) => {
    const head = page.locator('.verdict th', { hasText: 'largest distance' });
    await head.getByRole('button').click();
    await head.getByRole('button').click();
    assert.equal(await head.getAttribute('aria-sort'), 'descending');
    const names = await page.locator('.verdict tbody th').allInnerTexts();
    assert.deepEqual(names.map((n) => n.slice(0, 9)), ['variant 2', 'variant 1', 'variant 0']);
    const best = page.locator('.verdict tbody tr:has(th:text("variant 1")) td.best');
    assert.equal(await best.first().innerText(), '0.05');
    assert.match(await page.locator('.headline').innerText(), /variant 1 is nearest/);
    assert.equal(await page.locator('h1').innerText(), 'Generated </script><b>report</b>');
    assert.equal(await page.locator('h1 b').count(), 0, 'text never becomes markup');
  });
});

test('fits 360 px and 4K, light and dark', async () => {
  for (const [width, tall, colorScheme] of [[360, 740, 'dark'], [3840, 2160, 'light']]) {
    const viewport = { width, height: tall };
    await onPage(
      makeReport({ count: 6, parted: 1 }),
      async (page) => {
        const wide = await page.evaluate(() => document.documentElement.scrollWidth);
        assert.ok(wide <= width, `${wide} px on a screen of ${width}`);
        assert.equal(await page.locator('.tile:visible').count(), 6);
      },
      { viewport, colorScheme },
    );
  }
});

// How long it takes is bench/large_report.py's to measure: a loaded machine is no fault of the page.
test('a report of 257 × 257 nodes and 100 frames is small and opens', async () => {
  const report = makeReport({ count: 1, side: 257, frames: 100, withFields: false });
  const url = file(report);
  const size = readFileSync(new URL(url)).length;
  assert.ok(size < 60e6, `${size} bytes`);
  const page = await open(browser, url);
  const ms = await page.evaluate(() => performance.getEntriesByName('first picture')[0].startTime);
  console.log(`# ${(size / 1e6).toFixed(1)} MB, first picture after ${ms.toFixed(0)} ms`);
  assert.ok(ms > 0, `${ms} ms`);
  assert.deepEqual(page.trouble, []);
  await page.context().close();
});
