// Puts a report's data into the page, as `deform report` does. docs/report-format.md says how.
//   node scripts/embed.mjs DATA.json TEMPLATE.html OUT.html
import { readFileSync, writeFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

const kBefore = '<script id="deform-data" type="application/json">';
export const kPlaceholder = `${kBefore}null</script>`;

/** The page with `json` (text) in place of its placeholder, of which there must be exactly one. */
export function embed(page, json) {
  const parts = page.split(kPlaceholder);
  if (parts.length !== 2) throw new Error(`the page has ${parts.length - 1} placeholders, not 1`);
  return parts[0] + kBefore + json.replaceAll('<', '\\u003c') + '</script>' + parts[1];
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  const [data, template, out] = process.argv.slice(2);
  if (!out) {
    console.error('usage: node scripts/embed.mjs DATA.json TEMPLATE.html OUT.html');
    process.exit(2);
  }
  writeFileSync(out, embed(readFileSync(template, 'utf8'), readFileSync(data, 'utf8')));
}
