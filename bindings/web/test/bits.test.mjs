// Bits of native builds, compared: every scene of the catalog and of `crates/rhexis-scene/tests/golden` against `hashes.txt` there, whose native test
// takes any number of threads, wide and portable instructions; and the runs of `plan.json`, whose native test is `tests/bits.rs`.
// `node --test test/bits.test.mjs` after build.sh takes the module with SIMD; RHEXIS_BITS=all takes the plain one too,
// RHEXIS_SHARE=0/2 the first half of the runs and 1/2 the other.

import test from "node:test";
import assert from "node:assert/strict";
import { readdir, readFile } from "node:fs/promises";
import { load } from "../dist/index.js";
import { run } from "./plan.mjs";

const flavours = process.env.RHEXIS_BITS === "all" ? ["simd", "plain"] : ["simd"];
const folder = new URL("../../../crates/rhexis-scene/tests/golden/", import.meta.url);
const golden = await readFile(new URL("hashes.txt", folder), "utf8");
const files = (await readdir(folder)).filter((file) => file.endsWith(".toml"));
/** Texts of the scenes that are not in the catalog. */
const texts = new Map(await Promise.all(files.map(async (file) => [file.slice(0, -5), await readFile(new URL(file, folder), "utf8")])));
const scenes = [...golden.matchAll(/^any (\S+) (\d+) ([0-9a-f]{16})$/gm)].map(([, name, steps, hash]) => ({ name, steps: Number(steps), hash }));
const plan = JSON.parse(await readFile(new URL("plan.json", import.meta.url)));

const [share, shares] = (process.env.RHEXIS_SHARE ?? "0/1").split("/").map(Number);
const entries = [...scenes, ...plan].filter((_, index) => index % shares === share);

const known = new Set(texts.keys());
for (const flavour of flavours) {
  const engine = await load({ simd: flavour === "simd" });
  engine.catalog().forEach(({ name }) => known.add(name));
  for (const entry of entries) {
    const name = entry.name ?? entry.scene;
    test(`${flavour}: ${name}${entry.hand ? " by hand" : ""}, ${entry.steps} steps`, () => {
      assert.equal(engine.flavour, flavour);
      const world = run(engine, { scene: texts.get(name) ?? name, ...entry });
      const { hash, length_mm } = world.measures();
      world.free();
      assert.equal(hash, entry.hash);
      if (entry.lengthMm !== undefined) assert.equal(length_mm, entry.lengthMm);
    });
  }
}

test("every scene of the catalog and of the folder has its bits", () => {
  assert.deepEqual(scenes.map(({ name }) => name), [...known].sort());
});
