// The npm package in bundlers: `node test/bundlers/run.mjs [BUNDLER...]` after `build.sh all`. The package is packed and installed beside bundlers of the
// versions in `package-lock.json`, built by each, served, and run in headless Chromium: the bits are those of Node. Builds and
// settings are the ones that README.md tells.

import assert from "node:assert/strict";
import { execFile, spawn } from "node:child_process";
import { once } from "node:events";
import { existsSync } from "node:fs";
import { copyFile, cp, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { launch } from "../chromium.mjs";

const here = fileURLToPath(new URL(".", import.meta.url));
const bindings = fileURLToPath(new URL("../..", import.meta.url));
const execute = promisify(execFile);

/** By bundler: the command that builds into `dist`, the files that the README shows, and whether the command writes the page too. */
const BUNDLERS = {
  vite: { build: "npx vite build", files: ["vite.config.js"], hasPage: true, develop: "npx vite" },
  webpack: { build: "npx webpack", files: ["webpack.config.js"] },
  esbuild: { build: "npx esbuild main.js --bundle --format=esm --outdir=dist --loader:.wasm=file", files: ["engine.esbuild.js"] },
  rollup: { build: "npx rollup -c", files: ["rollup.config.js"] },
};
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };

/** Runs a command in a folder; throws with its output where it fails. */
async function command(line, cwd) {
  const [program, ...words] = line.split(" ");
  const { stdout } = await execute(program, words, { cwd, maxBuffer: 1 << 26 })
    .catch(({ stdout, stderr }) => assert.fail(`${line}\n${stdout}\n${stderr}`));
  return stdout;
}

/** Serves a folder on a free port; the address, and the server. */
async function serve(folder) {
  const server = createServer(async ({ url }, answer) => {
    const path = join(folder, normalize(new URL(url, "http://localhost").pathname).replace(/\/$/, "/index.html"));
    try {
      const bytes = await readFile(path);
      answer.writeHead(200, { "Content-Type": TYPES[extname(path)] ?? "application/octet-stream" }).end(bytes);
    } catch {
      answer.writeHead(404).end();
    }
  });
  await once(server.listen(0, "127.0.0.1"), "listening");
  return { address: `http://127.0.0.1:${server.address().port}/`, stop: () => server.close() };
}

/** Starts Vite's own server, which builds nothing beforehand. */
async function develop(line, cwd) {
  const [program, ...words] = line.split(" ");
  // Killed with its children.
  const child = spawn(program, [...words, "--host", "127.0.0.1", "--port", "0", "--clearScreen", "false"], { cwd, detached: true, stdio: ["ignore", "pipe", "inherit"] });
  let said = "";
  for await (const words of child.stdout) {
    said += `${words}`.replace(/\x1b\[\d+m/g, "");
    if (/http:\S+/.test(said)) break;
  }
  const [address] = said.match(/http:\S+/) ?? assert.fail(`${line}: ${said}`);
  return { address, stop: () => process.kill(-child.pid) };
}

/** The bits that the page has come to; without SIMD the browser says that it knows no such module. */
async function bitsIn(context, address, { query = "", hasNoSimd = false }) {
  const page = await context.newPage();
  const faults = [];
  page.on("pageerror", (error) => faults.push(`${error}`));
  page.on("console", (message) => { if (message.type() === "error") faults.push(message.text()); });
  if (hasNoSimd) await page.addInitScript(() => { WebAssembly.validate = () => false; });
  await page.goto(`${address}${query}`);
  await page.waitForFunction(() => window.bits, null, { timeout: 120_000 }).catch((error) => assert.fail(`${error}\n${faults.join("\n")}`));
  const bits = await page.evaluate(() => window.bits);
  await page.close();
  assert.deepEqual(faults, []);
  return bits;
}

const asked = process.argv.slice(2);
const unknown = asked.filter((name) => !BUNDLERS[name]);
assert.deepEqual(unknown, [], `bundlers are ${Object.keys(BUNDLERS).join(", ")}`);
for (const flavour of ["simd", "plain"]) {
  assert.ok(existsSync(join(bindings, "dist", flavour, "rhexis_web_bg.wasm")), `the module ${flavour} is missing: bindings/web/build.sh makes both`);
}

const work = await mkdtemp(join(tmpdir(), "rhexis-bundlers-"));
const { context, close } = await launch();
let failed = 0;
try {
  const readme = await readFile(join(bindings, "README.md"), "utf8");
  await cp(here, work, { recursive: true, filter: (path) => !path.endsWith("node_modules") });
  await command("npm ci --no-audit --no-fund", work);
  const packed = JSON.parse(await command(`npm pack --json --pack-destination ${work}`, bindings));
  await command(`npm install --no-save --no-audit --no-fund ${join(work, packed[0].filename)}`, work);
  await writeFile(join(work, "node.js"), `
    import { readFileSync } from "node:fs";
    import { load } from "rhexis";
    import { bitsOf } from "./bits.js";
    const bytes = readFileSync(new URL(import.meta.resolve("rhexis/plain.wasm")));
    console.log(JSON.stringify([await bitsOf(await load({ simd: true })), await bitsOf(await load({ simd: false, module: bytes }))]));
  `);
  const [simd, plain] = JSON.parse(await command("node node.js", work));
  assert.deepEqual([simd.flavour, plain.flavour], ["simd", "plain"]);
  assert.deepEqual({ ...plain, flavour: "simd" }, simd);
  console.log(`node: hash ${simd.hash}, torn to ${simd.length_mm.toFixed(3)} mm`);
  const runs = [
    { expected: simd, query: "?simd=true" }, { expected: plain, query: "?simd=false" },
    { expected: simd }, { expected: plain, hasNoSimd: true },
  ];

  for (const [name, { build, files, hasPage, develop: line }] of Object.entries(BUNDLERS)) {
    if (asked.length && !asked.includes(name)) continue;
    const begin = performance.now();
    let served, developed;
    try {
      for (const text of [build, ...(await Promise.all(files.map((file) => readFile(join(here, file), "utf8"))))]) {
        assert.ok(readme.includes(text.trim()), `README.md does not tell\n${text}`);
      }
      await rm(join(work, "dist"), { recursive: true, force: true });
      await copyFile(join(here, name === "esbuild" ? "engine.esbuild.js" : "engine.js"), join(work, "engine.js"));
      await command(build, work);
      if (!hasPage) await copyFile(join(work, "index.html"), join(work, "dist", "index.html"));
      served = await serve(join(work, "dist"));
      for (const { expected, ...run } of runs) assert.deepEqual(await bitsIn(context, served.address, run), expected);
      if (line) {
        developed = await develop(line, work);
        assert.deepEqual(await bitsIn(context, developed.address, {}), simd);
      }
      const version = JSON.parse(await readFile(join(work, "node_modules", name, "package.json"))).version;
      console.log(`ok: ${name} ${version} (${((performance.now() - begin) / 1000).toFixed(1)} s)`);
    } catch (error) {
      failed += 1;
      console.error(`FAILED: ${name}\n${error.stack ?? error}`);
    } finally {
      served?.stop();
      developed?.stop();
    }
  }
} finally {
  await close();
  await rm(work, { recursive: true, force: true });
}
process.exit(failed ? 1 : 0);
