// SPDX-License-Identifier: Apache-2.0
// Bundles the page into one file, dist/viewer.html, that needs no network. With --tests the tests are bundled as well,
// because node 20 does not read TypeScript. The output must be the same bytes for the same lock file: CI compares.
import { build } from 'esbuild';
import { mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';

const limitBytes = 1.2e6;
const sceneMarker = '<!-- rastro-scenes -->';

async function bundle(entry, loader) {
  const result = await build({
    entryPoints: [entry],
    bundle: true,
    minify: true,
    write: false,
    target: 'es2022',
    format: 'iife',
    charset: 'utf8',
    legalComments: 'none',
    loader,
  });
  return result.outputFiles[0].text.trim();
}

async function buildPage() {
  const style = await bundle('src/styles.css', { '.css': 'css' });
  const script = await bundle('src/main.ts', {});
  // A function as replacement: in a string, "$&" of the minified script would be read as a pattern.
  const page = readFileSync('src/index.html', 'utf8')
    .replace('/*style*/', () => style)
    .replace('/*script*/', () => script)
    .replace('/*license*/', () => readFileSync('node_modules/three/LICENSE', 'utf8').trim());
  if (page.split(sceneMarker).length !== 2) throw new Error(`the page must hold ${sceneMarker} exactly once`);
  const bytes = Buffer.from(page);
  if (bytes.length > limitBytes) throw new Error(`dist/viewer.html has ${bytes.length} bytes, at most ${limitBytes} allowed`);
  mkdirSync('dist', { recursive: true });
  writeFileSync('dist/viewer.html', bytes);
  console.log(`dist/viewer.html ${bytes.length} bytes`);
}

async function buildTests() {
  rmSync('test_out', { recursive: true, force: true });
  await build({
    entryPoints: readdirSync('tests').filter((f) => f.endsWith('.test.ts')).map((f) => `tests/${f}`),
    bundle: true,
    platform: 'node',
    target: 'node20',
    format: 'esm',
    outdir: 'test_out',
    outExtension: { '.js': '.mjs' },
    external: ['playwright-core'],
  });
}

await buildPage();
if (process.argv.includes('--tests')) await buildTests();
