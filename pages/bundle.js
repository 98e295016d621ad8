/**
 * Builds page.js from source/ and viewer.js from viewer/ and three.js, and the pages that edit facades and
 * designs of layers from their own source and some modules of others: `npm install && npm run build`.
 *
 * Each built file begins with the hash of what it was built from, so that a test can tell when one was forgotten.
 */
import { createHash } from "node:crypto";
import { readdirSync, readFileSync } from "node:fs";
import { basename } from "node:path";
import { build } from "esbuild";

const here = new URL(".", import.meta.url);
process.chdir(here.pathname);

/** What the pages of facades take from others. */
const SHARED = ["channel.js", "element.js", "menu.js", "transports.js"].map((name) => `source/${name}`);
const EDITOR = "../../facade/editor/page";
const DESIGNER = "../../facade/layers_page/page";
const STAGE = ["drag.js", "gestures.js", "help.js", "notes.js", "paint.js", "stage.js"];

/** @param {string} folder @param {string[]} shared */
function hashOf(folder, shared) {
  const files = readdirSync(folder)
    .sort()
    .map((file) => `${folder}/${file}`);
  files.push(...shared);
  const hash = createHash("sha256");
  for (const file of [...files, "package.json"]) hash.update(readFileSync(file));
  return hash.digest("hex").slice(0, 16);
}

/**
 * @param {string} folder
 * @param {string} entry
 * @param {string} outfile
 * @param {import("esbuild").BuildOptions} [options]
 * @param {string[]} [shared]
 */
async function bundle(folder, entry, outfile, options, shared = []) {
  await build({
    entryPoints: [`${folder}/${entry}`],
    outfile,
    bundle: true,
    format: "esm",
    target: "es2022",
    charset: "utf8",
    logLevel: "info",
    banner: { js: `/* Built from ${basename(folder)}/ by bundle.js; do not edit. Source ${hashOf(folder, shared)} */` },
    ...options,
  });
}

await bundle("source", "main.js", "page.js");
await bundle(`${EDITOR}/source`, "main.js", `${EDITOR}/page.js`, {}, SHARED);
const staged = STAGE.map((name) => `${EDITOR}/source/${name}`);
await bundle(`${DESIGNER}/source`, "main.js", `${DESIGNER}/page.js`, {}, [...SHARED, ...staged]);
await bundle("viewer", "viewer.js", "viewer.js", { minify: true, legalComments: "inline" });
