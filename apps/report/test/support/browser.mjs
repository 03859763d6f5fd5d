// Chromium for the tests, told to touch no network.
import { existsSync } from 'node:fs';
import { chromium } from 'playwright-core';

const kExecutable = process.env.DEFORM_CHROMIUM ?? '/usr/bin/chromium';
const kArguments = [
  '--no-sandbox',
  '--use-gl=angle',
  '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader',
  '--ignore-gpu-blocklist',
  '--disable-background-networking',
];

export async function launch() {
  if (!existsSync(kExecutable)) {
    throw new Error(`no ${kExecutable}: install chromium, or set DEFORM_CHROMIUM`);
  }
  return chromium.launch({ executablePath: kExecutable, args: kArguments });
}

/** Opens a page file and waits for its first picture; `page.trouble` collects what must not be. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({
    viewport: { width: 1400, height: 900 },
    ...options,
  });
  const page = await context.newPage();
  page.trouble = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type())) page.trouble.push(message.text());
  });
  page.on('pageerror', (error) => page.trouble.push(String(error)));
  page.on('request', (request) => {
    const allowed = /^(file|data|blob):/.test(request.url());
    if (!allowed) page.trouble.push(`request of ${request.url()}`);
  });
  await page.goto(url);
  await page.evaluate(() => window.deformReport.ready);
  return page;
}
