// What the types must allow; compiled, not run.

import { load, hasSimd, type Measures, type Surfaces, type World } from "../dist/index.js";

const engine = await load({ simd: hasSimd() });
await load({ simd: false, module: new URL("https://localhost/plain.wasm") });
await load({ module: fetch("simd.wasm") });
const world: World = engine.world({ scene: "fig2-tear", set: ["run.dt=5"], byHand: true, files: { "a.obj": new Uint8Array() } });
const place: Float64Array | undefined = world.grip([13, 28, 60], [0, 0, -1]);
if (place) world.moveGrip(place);
world.step(10);
const measures: Measures = world.measures();
const outcome: "closed" | "ran_out" | "torn_off" | "unfinished" | undefined = measures.bodies[0]?.course?.outcome;
const arrays: [Float32Array, Uint32Array] = [world.positions(), world.indices()];
const obstacles: Surfaces = world.obstacles();
world.record();
const hash: string = engine.replay(world.endRecording() ?? new Uint8Array());
console.log(outcome, hash, arrays, obstacles.positions.length, engine.catalog().map((entry) => entry.about), world.hash());
world.free();
