// Median processor times of a step in Node, beside native ones: `node test/times.mjs NATIVE [simd|plain]`, where NATIVE is what
// `cargo run --release -p rhexis-web --example times -- test/times.json` printed.

import { readFile } from "node:fs/promises";
import { load } from "../dist/index.js";
import { run } from "./plan.mjs";

const [, , path, flavour = "simd"] = process.argv;
if (!path) {
  console.error("usage: node test/times.mjs NATIVE [simd|plain]");
  process.exit(2);
}
const plan = JSON.parse(await readFile(new URL("times.json", import.meta.url)));
const natives = (await readFile(path, "utf8")).trim().split("\n").map((line) => JSON.parse(line));
const engine = await load({ simd: flavour === "simd" });
const median = (times) => times.sort((a, b) => a - b)[Math.floor(times.length / 2)] ?? 0;

console.log(`${"scene".padEnd(24)} ${"steps".padStart(5)}  native ms  ${flavour} ms  times`);
for (const [i, entry] of plan.entries()) {
  const times = [];
  const world = run(engine, entry, (world) => {
    const begin = process.cpuUsage();
    world.step(1);
    const { user, system } = process.cpuUsage(begin);
    times.push((user + system) / 1000);
  });
  world.free();
  const [ours, native] = [median(times), natives[i].step_ms];
  const numbers = [native.toFixed(2).padStart(10), ours.toFixed(2).padStart(8), (ours / native).toFixed(2).padStart(6)];
  console.log(`${entry.scene.padEnd(24)} ${String(entry.steps).padStart(5)} ${numbers.join(" ")}`);
}
