// The page in headless Chromium: loads, is dragged, torn, undone, worked by keys; its figures are the engine's, its hash the native one.
// `node test/browser.mjs [SCREENSHOTS]` after build.sh. RHEXIS_CHROMIUM is the browser, RHEXIS_PROGRAM the program rhexis that serves the page (by
// default that of the checkout), RHEXIS_REPLAY the example replay_recording, where it is built.
// With RHEXIS_CLOSE=FILE a scripted hand closes the capsulorhexis as well, in some minutes, and its recording is kept in FILE.

import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { launch } from "./chromium.mjs";
import { contrasts } from "./contrast.mjs";
import { close } from "./rhexis.mjs";

const screenshots = process.argv[2];
const plan = JSON.parse(await readFile(new URL("plan.json", import.meta.url)));

const [program, assets] = ["../../../target/release/rhexis", "../dist"].map((path) => fileURLToPath(new URL(path, import.meta.url)));
const server = spawn(process.env.RHEXIS_PROGRAM ?? program, ["view", "--port", "0", "--assets", assets], { stdio: ["ignore", "pipe", "inherit"] });
process.on("exit", () => server.kill());
const [said] = await once(server.stdout, "data");
const [address] = `${said}`.match(/http:\S+/);
const { context, profile, close: closeBrowser } = await launch({ width: 1280, height: 800 });
const faults = [];

async function open(query) {
  const page = await context.newPage();
  page.on("pageerror", (error) => faults.push(`${error}`));
  page.on("console", (message) => { if (message.type() === "error") faults.push(message.text()); });
  await page.goto(`${address}${query}`);
  await page.waitForFunction(() => document.documentElement.dataset.ready, null, { timeout: 120_000 });
  return page;
}

const call = (page, name, argument) => page.evaluate(([name, argument]) => window.rhexis.call(name, argument), [name, argument]);
const text = (page, id) => page.locator(`#${id}`).textContent();

/** Where a point of space is on the page. */
function onPage(page, point) {
  return page.evaluate((point) => {
    const { view } = window.rhexis;
    const at = view.project(view.vector(point));
    const box = view.canvas.getBoundingClientRect();
    return { x: box.left + (box.width * (at.x + 1)) / 2, y: box.top + (box.height * (1 - at.y)) / 2 };
  }, point);
}

/** Colour of the picture at a point of space. */
function pixel(page, point) {
  return page.evaluate((point) => {
    const { view } = window.rhexis;
    view.isStale = true;
    view.render();
    const gl = view.renderer.getContext();
    const at = view.project(view.vector(point));
    const colour = new Uint8Array(4);
    const place = [gl.drawingBufferWidth * (at.x + 1) / 2, gl.drawingBufferHeight * (at.y + 1) / 2].map(Math.floor);
    gl.readPixels(...place, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, colour);
    return [...colour];
  }, point);
}

async function drag(page, from, to, pause) {
  const [a, b] = [await onPage(page, from), await onPage(page, to)];
  await page.mouse.move(a.x, a.y);
  await page.mouse.down();
  await page.mouse.move(b.x, b.y, { steps: 12 });
  await page.waitForTimeout(pause);
}

/** Opens a recording on the page, which repeats it to the hash of its end. */
async function repeat(page, name, buffer, hash, timeout) {
  await page.locator("#file").setInputFiles({ name, mimeType: "application/octet-stream", buffer });
  await page.waitForFunction((hash) => document.getElementById("status").textContent.includes(`same hash ${hash}`), hash, { timeout })
    .catch(() => assert.fail("the page repeats the recording"));
}

/** Repeats a recording by the native engine. */
function repeatNatively(file, hash) {
  const said = execFileSync(process.env.RHEXIS_REPLAY, [file], { encoding: "utf8" });
  assert.ok(said.includes(hash), said);
}

async function until(page, holds, what, timeout = 60_000) {
  await page.waitForFunction(holds, null, { timeout }).catch(() => assert.fail(what));
}

const checks = {
  async "the hash in the browser is the native one"() {
    const entry = plan.find(({ scene, byHand }) => scene === "fig2-tear" && !byHand);
    for (const module of process.env.RHEXIS_BITS === "all" ? ["simd", "plain"] : ["simd"]) {
      const page = await open(`?scene=fig2-tear&scripted&module=${module}`);
      assert.equal(await page.evaluate(() => document.documentElement.dataset.ready), module);
      await call(page, "steps", entry.steps);
      assert.equal(await call(page, "hash"), entry.hash);
      await page.evaluate(() => { window.rhexis.state.isStale = true; });
      await until(page, () => document.getElementById("r-time").textContent.endsWith("step 500"), "the page shows the state");
      assert.equal(await text(page, "r-length"), `${entry.lengthMm.toFixed(3)} mm`);
      assert.equal(await text(page, "r-hash"), entry.hash);
      await page.close();
    }
  },

  async "a drag tears the square, and the page says how far"() {
    const page = await open("?scene=fig2-tear");
    await call(page, "record");
    const before = Number.parseFloat(await text(page, "r-length"));
    assert.equal(before, 3);
    await drag(page, [13.5, 28, 0], [4, 21, 0], 4000);
    await until(page, () => Number.parseFloat(document.getElementById("r-length").textContent) > 6, "the tear runs");
    if (screenshots) await page.screenshot({ path: join(screenshots, "square.png") });
    assert.match(await text(page, "r-hand"), /N$/);
    await page.mouse.up();
    await until(page, () => !window.rhexis.state.last.place, "the hand lets go");
    await page.evaluate(() => window.rhexis.play(false));
    await until(page, () => !window.rhexis.state.isAsking && !window.rhexis.state.isStale, "the page rests");
    const measures = await call(page, "measures");
    assert.equal(await text(page, "r-length"), `${measures.length_mm.toFixed(3)} mm`);
    assert.equal(await text(page, "r-hash"), measures.hash);
    console.log(`  torn to ${measures.length_mm.toFixed(3)} mm, step ${await text(page, "r-step")}, ${measures.steps} steps`);
    // What the hand did in the browser, repeated by the page and by the native program to the same hash.
    const bytes = Buffer.from(await page.evaluate(async () => Array.from(await window.rhexis.call("endRecording"))));
    await repeat(page, "drag.rec", bytes, measures.hash, 60_000);
    if (process.env.RHEXIS_REPLAY) {
      const file = join(profile, "drag.rec");
      await writeFile(file, bytes);
      repeatNatively(file, measures.hash);
    }
    await page.getByRole("button", { name: "Undo" }).click();
    await until(page, () => document.getElementById("r-length").textContent === "3.000 mm", "undo goes back");
    await page.close();
  },

  async "the capsule is drawn and torn"() {
    const page = await open("?scene=capsule-coarse");
    const tip = await page.evaluate(() => Array.from(window.rhexis.state.last.tips));
    const [first] = [0, 3].map((i) => tip.slice(i, i + 3)).filter((at) => at.length).sort((a, b) => b[1] - a[1]);
    const start = [first[0] - 0.15, first[1] - 0.45, first[2]];
    const length = await page.evaluate(() => window.rhexis.state.last.measures.length_mm);
    await drag(page, start, [start[0] - 2.2, start[1] + 0.8, start[2] + 1.2], 2000);
    await page.waitForFunction((length) => window.rhexis.state.last.measures.length_mm > length + 0.3, length, { timeout: 180_000 })
      .catch(() => assert.fail("the capsule tears"));
    if (screenshots) await page.screenshot({ path: join(screenshots, "capsule.png") });
    await page.mouse.up();
    assert.ok(await page.locator("#course").isVisible());
    assert.match(await text(page, "c-completion"), /°$/);
    console.log(`  capsule: step ${await text(page, "r-step")}, ${await text(page, "r-fps")}`);
    await page.close();
  },

  async "keys do what the mouse does"() {
    const page = await open("?scene=fig2-tear");
    await page.keyboard.press("Tab");
    assert.equal(await page.evaluate(() => document.activeElement.className), "skip");
    await page.keyboard.press("Enter");
    await page.locator("#stage").focus();
    await page.keyboard.press("Space");
    assert.equal(await text(page, "play"), "Play");
    const steps = await page.evaluate(() => window.rhexis.state.last.measures.steps);
    await page.keyboard.press(".");
    await page.waitForFunction((steps) => window.rhexis.state.last.measures.steps === steps + 1, steps);
    await page.keyboard.press("t");
    assert.ok(await page.locator("#cursor").isVisible());
    for (let i = 0; i < 3; i++) await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("ArrowUp");
    await page.keyboard.press("g");
    await until(page, () => window.rhexis.state.last.place, "the hand grips");
    for (let i = 0; i < 8; i++) await page.keyboard.press("Shift+ArrowLeft");
    for (let i = 0; i < 5; i++) await page.keyboard.press("Shift+ArrowDown");
    await until(page, () => window.rhexis.state.last.measures.length_mm > 4, "keys tear");
    await page.keyboard.press("g");
    await until(page, () => !window.rhexis.state.last.place, "the hand lets go");
    await page.keyboard.press("z");
    await until(page, () => window.rhexis.state.last.measures.length_mm === 3, "Z undoes");
    await page.keyboard.press("r");
    await until(page, () => window.rhexis.state.last.measures.steps < 5, "R resets");
    // Every control is reached and named.
    const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select, textarea, canvas, summary")]
      .filter((node) => !(node.getAttribute("aria-label") || node.labels?.length || node.textContent.trim())).map((node) => node.outerHTML));
    assert.deepEqual(nameless, []);
    const seen = new Set();
    await page.locator("#stage").focus();
    for (let i = 0; i < 60; i++) {
      await page.keyboard.press("Tab");
      seen.add(await page.evaluate(() => document.activeElement.id || document.activeElement.textContent.trim()));
    }
    for (const id of ["play", "step", "reset", "scene", "scripted", "fibres", "tips", "mesh", "obstacles", "file", "unit", "angle", "record", "Keys"]) {
      assert.ok(seen.has(id), `${id} is not reached by Tab: ${[...seen]}`);
    }
    await page.close();
  },

  async "obstacles are in the picture, and move"() {
    const page = await open("");
    const scene = await readFile(new URL("pushed.toml", import.meta.url));
    await page.locator("#file").setInputFiles({ name: "pushed.toml", mimeType: "text/plain", buffer: scene });
    await until(page, () => document.getElementById("status").textContent.includes("ready"), "the scene is opened");
    const top = () => page.evaluate(() => Math.max(...window.rhexis.view.obstacles.geometry.getAttribute("position").array.filter((_, i) => i % 3 === 1)));
    assert.ok(Math.abs((await top()) - 22) < 1e-4, `${await top()}`);
    // Its upper end comes where the ground was.
    const before = await pixel(page, [36, 28, 2]);
    await page.evaluate(() => window.rhexis.play(true));
    await until(page, () => window.rhexis.state.last.measures.steps >= 110, "the scene runs");
    await page.evaluate(() => window.rhexis.play(false));
    await until(page, () => !window.rhexis.state.isAsking, "the page rests");
    assert.ok(Math.abs((await top()) - 32) < 1e-4, `${await top()}`);
    const after = await pixel(page, [36, 28, 2]);
    assert.notDeepEqual(after, before, "the capsule is drawn where it has come");
    if (screenshots) await page.screenshot({ path: join(screenshots, "obstacles.png") });
    await page.getByLabel("Obstacles").uncheck();
    assert.deepEqual(await pixel(page, [36, 28, 2]), before, "obstacles are hidden on demand");
    await page.close();
  },

  async "text has the contrast that reading takes"() {
    const page = await open("?scene=capsulorhexis");
    await page.evaluate(() => document.querySelectorAll("details").forEach((node) => { node.open = true; }));
    const poor = (await page.evaluate(contrasts)).filter(({ ratio }) => ratio < 4.5);
    assert.deepEqual(poor, [], "WCAG 2 asks for 4.5:1");
    await page.close();
  },

  async "a mesh of one's own is chosen, cut and torn; a bad one is refused in words"() {
    const page = await open("");
    const lines = [];
    const n = 24;
    for (let j = 0; j <= n; j++) for (let i = 0; i <= n; i++) lines.push(`v ${i} ${j} ${0.02 * (i * (n - i) + j * (n - j))}`);
    for (let j = 0; j < n; j++) for (let i = 0; i < n; i++) {
      const a = j * (n + 1) + i + 1;
      lines.push(`f ${a} ${a + 1} ${a + n + 2}`, `f ${a} ${a + n + 2} ${a + n + 1}`);
    }
    await page.locator("#file").setInputFiles({ name: "dome.obj", mimeType: "text/plain", buffer: Buffer.from(lines.join("\n")) });
    await until(page, () => window.rhexis.state.about?.name === "dome", "the mesh is opened");
    await page.getByLabel("Blade").check();
    const top = (x, y) => [x, y, 0.02 * (x * (n - x) + y * (n - y))];
    await drag(page, top(8, 12), top(16, 12), 100);
    await page.mouse.up();
    await until(page, () => window.rhexis.state.last.measures.length_mm > 7, "the blade cuts");
    const cut = await page.evaluate(() => window.rhexis.state.last.measures.length_mm);
    await page.getByLabel("Forceps").check();
    await drag(page, top(12, 11), top(12, -2), 1500);
    await page.waitForFunction((cut) => window.rhexis.state.last.measures.length_mm > cut + 1, cut, { timeout: 60_000 })
      .catch(() => assert.fail("the mesh tears"));
    if (screenshots) await page.screenshot({ path: join(screenshots, "own-mesh.png") });
    await page.mouse.up();
    await page.locator("#file").setInputFiles({ name: "bad.obj", mimeType: "text/plain", buffer: Buffer.from("v 0 0 x\n") });
    await until(page, () => document.getElementById("status").textContent.includes("bad.obj:1"), "a bad mesh is refused");
    await page.close();
  },

  async "pictures of 5,000 triangles"() {
    const page = await open("?scene=capsulorhexis&scripted");
    await page.evaluate(() => window.rhexis.play(true));
    // A rate takes two pictures within a second, hence a first step that is through.
    await page.waitForFunction(() => window.rhexis.state.last.measures.steps >= 60, null, { timeout: 300_000 }).catch(() => assert.fail("it runs"));
    const [rate, step] = [await text(page, "r-fps"), await text(page, "r-step")];
    const triangles = await text(page, "r-triangles");
    console.log(`  ${triangles} triangles: ${rate}, step ${step} (software drawing, no graphics processor)`);
    await page.close();
  },
};

/** The page's calls, led by a hand to the tear's end: kept, and repeated by the page and natively. */
async function closeTear() {
  const page = await open("?scene=capsule-coarse");
  await page.evaluate(() => window.rhexis.play(false));
  await until(page, () => !window.rhexis.state.isAsking, "the page rests");
  await call(page, "reset");
  await call(page, "record");
  const course = await close((name, argument) => call(page, name, argument));
  assert.equal(course.outcome, "closed");
  // The page's step time is of its first steps; these were not timed.
  await page.evaluate(() => Object.assign(window.rhexis.state, { isStale: true, stepTime: undefined }));
  await until(page, () => document.getElementById("c-outcome").textContent === "closed", "the page shows the end");
  if (screenshots) await page.screenshot({ path: join(screenshots, "closed.png") });
  const hash = await call(page, "hash");
  const bytes = Buffer.from(await page.evaluate(async () => Array.from(await window.rhexis.call("endRecording"))));
  await writeFile(process.env.RHEXIS_CLOSE, bytes);
  const [diameter, kilobytes] = [course.diameter_mm.toFixed(2), (bytes.length / 1000).toFixed(0)];
  const [seconds, force] = [(course.time_ms / 1000).toFixed(1), (1000 * course.force_rms_n).toFixed(1)];
  const figures = `circularity ${course.circularity.toFixed(3)}, ${course.grasps} grasps in ${seconds} s, ${force} mN RMS`;
  console.log(`  closed at ${diameter} mm, ${figures}; hash ${hash}, ${kilobytes} kB`);
  if (process.env.RHEXIS_REPLAY) repeatNatively(process.env.RHEXIS_CLOSE, hash);
  await repeat(page, "closed.rec", bytes, hash, 600_000);
  await page.close();
}
if (process.env.RHEXIS_CLOSE) checks["a hand closes the capsulorhexis"] = closeTear;

let failed = 0;
for (const [name, check] of Object.entries(checks)) {
  if (process.env.RHEXIS_CHECK && !name.includes(process.env.RHEXIS_CHECK)) continue;
  const begin = performance.now();
  try {
    await check();
    assert.deepEqual(faults, []);
    console.log(`ok: ${name} (${((performance.now() - begin) / 1000).toFixed(1)} s)`);
  } catch (error) {
    failed += 1;
    console.error(`FAILED: ${name}\n${error.stack ?? error}\n${faults.splice(0).join("\n")}`);
  }
}
await closeBrowser();
process.exit(failed ? 1 : 0);
