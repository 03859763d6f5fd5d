import { existsSync, readFileSync } from 'node:fs';
import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';
import { embed } from './scripts/embed.mjs';

// The page may load nothing: the browser itself refuses any request.
const kPolicy =
  '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; ' +
  'script-src \'unsafe-inline\'; style-src \'unsafe-inline\'; img-src data: blob:" />';

/** The licence texts that the bundled libraries ask to be kept with every copy. */
function notices() {
  const texts = ['three', 'uplot'].map((name) => {
    const text = readFileSync(`node_modules/${name}/LICENSE`, 'utf8').trim();
    return `This page contains ${name}:\n\n${text}`;
  });
  return `<!--\n${texts.join('\n\n').replaceAll('--', '- -')}\n-->`;
}

/** What makes the page a template: its name, the policy, the notices; in development the sample. */
function reportPage(command) {
  return {
    name: 'report-page',
    enforce: 'post',
    transformIndexHtml: {
      order: 'post',
      handler(html) {
        if (command === 'build') {
          return html.replace('<meta charset', `${notices()}\n    ${kPolicy}\n    <meta charset`);
        }
        const sample = 'sample/comparison.json';
        return existsSync(sample) ? embed(html, readFileSync(sample, 'utf8')) : html;
      },
    },
    generateBundle(_options, bundle) {
      const page = bundle['index.html'];
      if (page) page.fileName = 'report.html';
    },
  };
}

export default defineConfig(({ command }) => ({
  plugins: [viteSingleFile({ removeViteModuleLoader: true }), reportPage(command)],
  build: {
    target: 'es2022',
    modulePreload: false,
    reportCompressedSize: false,
    chunkSizeWarningLimit: 2000,
  },
}));
