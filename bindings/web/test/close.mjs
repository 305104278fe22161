// A capsulorhexis closed by a scripted hand, recorded and repeated: `node test/close.mjs [FILE]` after build.sh; FILE is where the recording goes,
// for `cargo run --release -p rhexis-web --example replay_recording -- FILE`.

import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import { load } from "../dist/index.js";
import { CAPSULE, close } from "./rhexis.mjs";

const engine = await load();
const world = engine.world(CAPSULE);
const calls = {
  tips: () => world.tips(),
  measures: () => world.measures(),
  steps: (count) => world.step(count),
  grip: ({ origin, direction }) => world.grip(origin, direction) ?? null,
  moveGrip: (target) => world.moveGrip(target),
  letGo() {
    world.letGo();
    console.log(`let go after ${world.steps} steps, ${world.measures().bodies[0].course.completion_deg.toFixed(0)}° torn`);
  },
};

world.record();
const begin = performance.now();
const { outcome, completion_deg, diameter_mm, circularity, decentration_mm, grasps } = await close(async (name, argument) => calls[name](argument));
const seconds = (performance.now() - begin) / 1000;
console.log({ outcome, completion_deg, diameter_mm, circularity, decentration_mm, grasps, steps: world.steps, seconds: Number(seconds.toFixed(1)) });
const [hash, recording] = [world.hash(), world.endRecording()];
if (process.argv[2]) await writeFile(process.argv[2], recording);
assert.equal(outcome, "closed");
assert.equal(engine.replay(recording), hash);
console.log(`repeated to the same hash ${hash}`);
