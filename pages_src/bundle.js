/**
 * Builds every page into the package that serves it, and viewer.js from three.js: `npm install && npm run build`.
 *
 * Each built file begins with the folders it was built from and their hash, so that a test can detect files that
 * were not rebuilt.
 */
import { createHash } from "node:crypto";
import { readdirSync, readFileSync } from "node:fs";
import { build } from "esbuild";

process.chdir(new URL(".", import.meta.url).pathname);
const FACADE = "../grammarlab/runs/facade";

/**
 * @param {string} entry
 * @param {string} outfile
 * @param {string[]} folders that may be read
 * @param {import("esbuild").BuildOptions} [options]
 */
async function bundle(entry, outfile, folders, options) {
  const hash = createHash("sha256");
  for (const folder of folders)
    for (const name of readdirSync(folder).sort()) hash.update(readFileSync(`${folder}/${name}`));
  hash.update(readFileSync("package.json"));
  const banner = `/* Built from ${folders.join(", ")} by pages/bundle.js; do not edit. Source ${hash.digest("hex").slice(0, 16)} */`;
  const { metafile } = await build({
    entryPoints: [entry],
    outfile,
    bundle: true,
    format: "esm",
    target: "es2022",
    charset: "utf8",
    logLevel: "info",
    banner: { js: banner, css: banner },
    metafile: true,
    ...options,
  });
  for (const input of Object.keys(metafile.inputs))
    if (![...folders, "node_modules"].includes(input.split("/")[0])) throw new Error(`${entry} may not read ${input}`);
}

/** @param {string} name @param {string} home package that serves it @param {string[]} shared */
async function page(name, home, ...shared) {
  const folders = [...shared, name];
  await bundle(`${name}/main.js`, `${home}/static/page.js`, folders);
  await bundle(`${name}/page.css`, `${home}/static/page.css`, folders, { minify: true, target: "esnext" });
}

await page("scoring", "../grammarlab/scoring", "shared");
await page("editor", `${FACADE}/editor`, "shared", "stage");
await page("layers", `${FACADE}/layers_page`, "shared", "stage");
await page("example", `${FACADE}/example_page`, "shared");
await page("scan", `${FACADE}/scan_page`, "shared");
const viewer = { minify: true, legalComments: /** @type {const} */ ("inline") };
await bundle("viewer/viewer.js", "../grammarlab/scoring/static/viewer.js", ["viewer"], viewer);
