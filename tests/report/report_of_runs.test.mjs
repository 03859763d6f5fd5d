// What the program writes, in a real browser: a run's report, a comparison's, the contact sheet.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { launch, open } from '../../apps/report/test/support/browser.mjs';
import { different, readPng } from '../../apps/report/test/support/picture.mjs';
import { readTrajectory } from './trajectory.mjs';

const kProgram = process.env.DEFORM_PROGRAM;
const kScene = join(process.env.DEFORM_SCENES, 'paper/fig07_paper_gauss.json');
let browser;
let folder;

before(async () => {
  browser = await launch();
  // Blanks, and what has a meaning in an address.
  folder = mkdtempSync(join(tmpdir(), 'deform report #1 '));
});

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

/** Simulates half a second of the paper's sheet. */
function simulate(name, ...options) {
  const out = join(folder, name);
  const all = ['run', kScene, '--out', out, '--quiet', '--set', '/duration=0.5', ...options];
  const { status, stderr } = spawnSync(kProgram, all, { encoding: 'utf8' });
  return { out, status, stderr };
}

function report(...options) {
  return spawnSync(kProgram, ['report', ...options], { encoding: 'utf8' });
}

async function onPage(path, act) {
  const page = await open(browser, pathToFileURL(path).href);
  try {
    await act(page);
    assert.deepEqual(page.trouble, []);
  } finally {
    await page.context().close();
  }
}

/** Every node of a variant, at each of these frames, is where the trajectory has it. */
async function comparePositions(page, name, trajectory, frames) {
  const { extent } = trajectory;
  for (const frame of frames) {
    const shown = await page.evaluate(
      ([n, f, count]) => {
        deformReport.setTime(f);
        return Array.from({ length: count }, (_, k) => deformReport.position(n, k));
      },
      [name, frame, trajectory.nodes],
    );
    const recorded = trajectory.positions(frame);
    shown.forEach((r, k) => {
      r.forEach((x, c) => {
        // Half a level, and what single precision rounds.
        const limit = (0.5 * extent[c]) / 65534 + 1e-7 * (Math.abs(x) + extent[c]);
        assert.ok(Math.abs(x - recorded[c][k]) <= limit, `node ${k}, ${c}: ${x}`);
      });
    });
  }
}

test('a run ends with its report; the page shows what was recorded', async () => {
  const { out, status } = simulate('run');
  assert.equal(status, 0);
  const trajectory = readTrajectory(join(out, 'trajectory.bin'));
  await onPage(join(out, 'report.html'), async (page) => {
    const last = trajectory.moments.length - 1;
    await comparePositions(page, 'run', trajectory, [0, 7, last]);
    const slider = page.getByRole('slider', { name: 'Time' });
    assert.equal(await slider.inputValue(), String(last));
    const picture = async () => readPng(await page.locator('.surface').screenshot());
    const late = await picture();
    await slider.fill('3');
    assert.ok(different(late, await picture()) > 0.002, 'the slider moves the sheet');
    await slider.fill(String(last));
    const names = trajectory.fields.map((field) => field.name);
    assert.ok(names.includes('B_11') && names.includes('branch'), names.join());
    let before = late;
    for (const name of names) {
      await page.getByLabel('Colour', { exact: true }).selectOption(name);
      const now = await picture();
      assert.ok(different(before, now) > 0.001, `${name} looks like what was shown before`);
      before = now;
    }
    const columns = readFileSync(join(out, 'probes.csv'), 'utf8').split('\n')[0].split(',');
    const plots = page.locator('.plot');
    assert.equal(await plots.count(), columns.length - 2);
    await plots.last().scrollIntoViewIfNeeded();
    await plots.last().locator('canvas').waitFor();
    assert.ok(readPng(await plots.last().screenshot()).colours > 20, 'a plot is drawn');
  });
});

test('deform report makes the same page again', () => {
  const { out } = simulate('again');
  const first = readFileSync(join(out, 'report.html'));
  rmSync(join(out, 'report.html'));
  const { status, stdout } = report(out);
  assert.equal(status, 0);
  assert.equal(stdout, `${join(out, 'report.html')}\n`);
  assert.ok(first.equals(readFileSync(join(out, 'report.html'))));
});

test('deform report --png makes a contact sheet', () => {
  const { out } = simulate('sheet');
  const { status, stdout, stderr } = report(out, '--png');
  assert.equal(status, 0, stderr);
  assert.equal(stdout, `${join(out, 'report.html')}\n${join(out, 'report.png')}\n`);
  const picture = readPng(readFileSync(join(out, 'report.png')));
  assert.deepEqual([picture.width, picture.height], [190 + 5 * 400, 40 + 288 + 84]);
  for (let column = 0; column < 5; ++column) {
    assert.ok(picture.share(190 + 400 * column, 40, 400, 288, 245) > 0.1, `picture ${column}`);
  }
  assert.ok(picture.colours > 100);
});

test('without frames there is no report, and a report made then says so', async () => {
  const { out, status } = simulate('bare', '--set', '/frames={"write":false}');
  assert.equal(status, 0);
  assert.ok(!existsSync(join(out, 'report.html')));
  assert.equal(report(out).status, 0);
  await onPage(join(out, 'report.html'), async (page) => {
    assert.ok((await page.locator('.plot').count()) > 0);
  });
  const { status: failed, stderr } = report(out, '--png');
  assert.equal(failed, 1);
  assert.match(stderr, /there is no shape to show/);
});

test('a run that diverges has a report with the reason', async () => {
  const { out, status } = simulate('gone', '--set', '/energies/1/xi=100');
  assert.equal(status, 3);
  const { reason } = JSON.parse(readFileSync(join(out, 'summary.json'), 'utf8'));
  await onPage(join(out, 'report.html'), async (page) => {
    assert.ok((await page.locator('.reasons').innerText()).includes(reason));
  });
});

test('what is neither a run nor a comparison is refused; so is a missing Chromium', () => {
  const { status, stderr } = report(folder);
  assert.equal(status, 2);
  assert.match(stderr, /neither a run directory nor a comparison directory/);
  const { out } = simulate('alone');
  const env = { PATH: '/nowhere' };
  const missing = spawnSync(kProgram, ['report', out, '--png'], { encoding: 'utf8', env });
  assert.equal(missing.status, 2);
  assert.match(missing.stderr, /DEFORM_CHROMIUM/);
  env.DEFORM_CHROMIUM = '/nowhere/chromium';
  const wrong = spawnSync(kProgram, ['report', out, '--png'], { encoding: 'utf8', env });
  assert.equal(wrong.status, 1);
  assert.match(wrong.stderr, /\/nowhere\/chromium: cannot be started/);
});

/** A comparison directory of three runs: the sheet, one on a finer grid, one that never began. */
function comparison() {
  const out = join(folder, 'comparison');
  const names = ['gauss', 'refined'];
  cpSync(simulate('gauss').out, join(out, 'gauss'), { recursive: true });
  const finer = ['/surface/nodes=[41,41]', '/integrator/step=0.01', '/frames={"every":2}'];
  const refined = simulate('refined', ...finer.flatMap((value) => ['--set', value]));
  assert.equal(refined.status, 0, refined.stderr);
  cpSync(refined.out, join(out, 'refined'), { recursive: true });
  const entry = (name) => ({
    name, folder: name, status: 'done', reason: '', changes: [], dropped: [], parts: null,
  });
  const variants = names.map(entry);
  variants.push({ ...entry('wrong'), status: 'refused', reason: 'there is no normal plugin "x"' });
  const summary = {
    kind: 'comparison', title: 'Two grids <b>', reference: 'refined', verdict: null,
    tolerance: { value: 0.01, unit: 'm' }, scene: {}, variants,
  };
  writeFileSync(join(out, 'summary.json'), JSON.stringify(summary));
  return out;
}

test('a comparison shows all variants at equal times on one mesh', async () => {
  const out = comparison();
  assert.equal(report(out).status, 0);
  const coarse = readTrajectory(join(out, 'gauss/trajectory.bin'));
  const fine = readTrajectory(join(out, 'refined/trajectory.bin'));
  await onPage(join(out, 'report.html'), async (page) => {
    assert.equal(await page.locator('.tile:visible').count(), 3);
    await comparePositions(page, 'gauss', coarse, [0, 11, coarse.moments.length - 1]);
    // Every second node of every second row of the finer grid, at the same time.
    const frame = 20;
    const at = fine.moments.findIndex((m) => Math.abs(m.time - coarse.moments[frame].time) < 1e-9);
    const recorded = fine.positions(at);
    const shown = await page.evaluate(
      ([f]) => {
        deformReport.setTime(f);
        return Array.from({ length: 21 * 21 }, (_, k) => deformReport.position('refined', k));
      },
      [frame],
    );
    shown.forEach((r, k) => {
      const node = 2 * Math.floor(k / 21) * 41 + 2 * (k % 21);
      r.forEach((x, c) => assert.ok(Math.abs(x - recorded[c][node]) < 2e-5, `${k}, ${c}`));
    });
    assert.match(await page.locator('.notes').innerText(), /refined: computed on other nodes/);
    assert.match(await page.locator('.reasons').innerText(), /no normal plugin "x"/);
    assert.equal(await page.locator('h1').innerText(), 'Two grids <b>');
  });
});
