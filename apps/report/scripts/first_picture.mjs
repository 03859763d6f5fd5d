// How long a page takes from the address to its first picture, and between pictures.
//   node scripts/first_picture.mjs REPORT.html
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { launch, open } from '../test/support/browser.mjs';

const [file] = process.argv.slice(2);
if (!file) {
  console.error('usage: node scripts/first_picture.mjs REPORT.html');
  process.exit(2);
}
const browser = await launch();
const page = await open(browser, pathToFileURL(resolve(file)).href);
const times = await page.evaluate(() => {
  const first = performance.getEntriesByName('first picture')[0].startTime;
  const begin = performance.now();
  deformReport.setTime(0);
  deformReport.setTime(1);
  return { first, frame: (performance.now() - begin) / 2 };
});
console.log(`first picture after ${(times.first / 1e3).toFixed(2)} s`);
console.log(`another moment after ${times.frame.toFixed(0)} ms`);
console.log(page.trouble.length > 0 ? page.trouble.join('\n') : 'no error on the console');
await browser.close();
