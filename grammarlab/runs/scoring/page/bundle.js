/**
 * Builds page.js from source/ and viewer.js from viewer/ and three.js: `npm install && npm run build`.
 *
 * Each built file begins with the hash of what it was built from, so that a test can tell when one was forgotten.
 */
import { createHash } from "node:crypto";
import { readdirSync, readFileSync } from "node:fs";
import { build } from "esbuild";

const here = new URL(".", import.meta.url);
process.chdir(here.pathname);

/** @param {string} folder */
function hashOf(folder) {
  const files = readdirSync(folder)
    .sort()
    .map((file) => `${folder}/${file}`);
  const hash = createHash("sha256");
  for (const file of [...files, "package.json"]) hash.update(readFileSync(file));
  return hash.digest("hex").slice(0, 16);
}

/** @param {string} folder @param {string} entry @param {string} outfile @param {import("esbuild").BuildOptions} options */
async function bundle(folder, entry, outfile, options) {
  await build({
    entryPoints: [`${folder}/${entry}`],
    outfile,
    bundle: true,
    format: "esm",
    target: "es2022",
    charset: "utf8",
    logLevel: "info",
    banner: { js: `/* Built from ${folder}/ by bundle.js; do not edit. Source ${hashOf(folder)} */` },
    ...options,
  });
}

await bundle("source", "main.js", "page.js", {});
await bundle("viewer", "viewer.js", "viewer.js", { minify: true, legalComments: "inline" });
