/**
 * Builds every page into a folder of grammarlab/pages/static, and viewer.js from three.js: `npm install && npm run build`.
 *
 * Each built file begins with the folders it was built from and their hash, so that a test can detect files that
 * were not rebuilt.
 */
import { createHash } from "node:crypto";
import { readdirSync, readFileSync } from "node:fs";
import { build } from "esbuild";

process.chdir(new URL(".", import.meta.url).pathname);
const STATIC = "../grammarlab/pages/static";

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
  const banner = `/* Built from ${folders.join(", ")} by pages_src/bundle.js; do not edit. Source ${hash.digest("hex").slice(0, 16)} */`;
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

/** @param {string} name @param {string[]} shared @param {import("esbuild").BuildOptions} [options] of its script */
async function page(name, shared, options) {
  const folders = [...shared, name];
  await bundle(`${name}/main.js`, `${STATIC}/${name}/page.js`, folders, options);
  await bundle(`${name}/page.css`, `${STATIC}/${name}/page.css`, folders, { minify: true, target: "esnext" });
}

// Scripts with three.js are large.
const minified = { minify: true, legalComments: /** @type {const} */ ("inline") };

await page("scoring", ["shared"]);
await page("editor", ["shared", "stage"]);
await page("layers", ["shared", "stage"]);
await page("example", ["shared"]);
await page("scan", ["shared"]);
await page("watch", ["shared"]);
await page("view", ["shared", "viewer"], minified);
await page("city", ["shared"], minified);
await bundle("viewer/viewer.js", `${STATIC}/scoring/viewer.js`, ["viewer"], minified);
