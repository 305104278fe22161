// What the package promises: errors, undo, arrays, the blade, meshes, recordings. `node --test test/node.test.mjs` after build.sh.

import test from "node:test";
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { load } from "../dist/index.js";

const engine = await load();

test("the catalog has the scenes with their texts", () => {
  const names = engine.catalog().map((entry) => entry.name);
  assert.ok(names.includes("fig2-tear") && names.includes("capsulorhexis"));
  assert.ok(engine.catalog().every((entry) => entry.about && entry.text.includes("[scene]")));
});

test("errors say place and remedy, and leave the module usable", () => {
  assert.throws(() => engine.world({ scene: "fig2-taer" }), /did you mean `fig2-tear`/);
  assert.throws(() => engine.world({ scene: "[run]\ndt = 1\nstep = 3\n" }), /scene\.toml.*steps/s);
  assert.throws(() => engine.World.fromMesh("a.obj", new TextEncoder().encode("v 0 0 x\n"), "mm", [1, 0, 0]), /a\.obj:1/);
  const world = engine.world({ scene: "free-triangle" });
  assert.throws(() => world.grip([0, 0], [0, 0, 1]), /three finite numbers/);
  assert.throws(() => world.vertexValues("heat"), /stress/);
  world.step(1);
  world.free();
});

test("undo and reset go back to the same bits", () => {
  const world = engine.world({ scene: "fig2-tear", byHand: true });
  const start = world.hash();
  world.step(3);
  const before = world.hash();
  const place = world.grip([13.5, 27.5, 60], [0, 0, -1]);
  world.moveGrip([place[0] - 5, place[1] - 3, 0]);
  world.step(40);
  const torn = world.hash();
  assert.ok(world.measures().length_mm > 3.5);
  assert.ok(world.undo());
  assert.equal(world.hash(), before);
  assert.equal(world.undo(), false);
  const again = world.grip([13.5, 27.5, 60], [0, 0, -1]);
  assert.deepEqual([...again], [...place]);
  world.moveGrip([place[0] - 5, place[1] - 3, 0]);
  world.step(40);
  assert.equal(world.hash(), torn);
  world.reset();
  assert.equal(world.hash(), start);
  world.free();
});

test("arrays go together", () => {
  const world = engine.world({ scene: "fig2-tear", byHand: true });
  world.step(1);
  const [positions, indices] = [world.positions(), world.indices()];
  const triangles = indices.length / 3;
  assert.ok(positions instanceof Float32Array && indices instanceof Uint32Array);
  assert.ok(Math.max(...indices) < positions.length / 3);
  for (const what of ["stress", "criterion"]) {
    assert.equal(world.triangleValues(what).length, triangles);
    assert.equal(world.vertexValues(what).length, positions.length / 3);
  }
  assert.equal(world.fibres().length, 6 * triangles);
  assert.equal(world.tips().length, 3);
  assert.equal(world.measures().bodies[0].triangles, triangles);
  world.free();
});

test("obstacles are surfaces that move with the scene", async () => {
  const world = engine.world({ scene: await readFile(new URL("pushed.toml", import.meta.url), "utf8") });
  for (const steps of [0, 40]) {
    world.step(steps);
    const { positions, indices } = world.obstacles();
    assert.ok(positions instanceof Float32Array && indices instanceof Uint32Array);
    const points = Array.from({ length: positions.length / 3 }, (_, i) => Array.from(positions.subarray(3 * i, 3 * i + 3)));
    assert.ok(Math.max(...indices) === points.length - 1 && indices.length % 3 === 0);
    const ball = points.filter(([x]) => x < 30).map(([x, y, z]) => Math.hypot(x - 15, y - 15, z + 4 - steps * 0.05));
    assert.ok(ball.length > 500 && ball.every((radius) => Math.abs(radius - 4) < 1e-5));
    const rod = points.filter(([x]) => x > 30).map(([, y]) => y - steps * 0.1);
    assert.ok(Math.abs(Math.min(...rod) + 2) < 1e-5 && Math.abs(Math.max(...rod) - 22) < 1e-5);
  }
  assert.ok(Math.max(...world.positions().filter((_, i) => i % 3 === 2)) > 1, "the ball has pushed the sheet");
  world.free();
  const bare = engine.world({ scene: "fig2-tear" });
  assert.equal(bare.obstacles().positions.length, 0);
  bare.free();
});

test("a blade cuts, a cut beside the tissue is refused and changes nothing", () => {
  const world = engine.world({ scene: "fig2-tear", byHand: true });
  const before = world.hash();
  assert.throws(() => world.cut([5, 5, 60], [0, 0, -1], [10, 0, 0.1]), /beside the tissue/);
  assert.equal(world.hash(), before);
  const made = world.cut([5, 5, 60], [0, 0, -1], [0.1, 0.05, -1]);
  // The second ray meets the plane 6 mm and 3 mm further on.
  assert.ok(Math.abs(made - Math.hypot(6, 3)) < 1e-9, `${made}`);
  assert.equal(world.undoCount, 1);
  world.free();
});

/** A square sheet as OBJ, in centimetres. */
function sheet(n) {
  const lines = [];
  for (let j = 0; j <= n; j++) for (let i = 0; i <= n; i++) lines.push(`v ${(3 * i) / n} ${(3 * j) / n} 0`);
  for (let j = 0; j < n; j++) for (let i = 0; i < n; i++) {
    const a = j * (n + 1) + i + 1;
    lines.push(`f ${a} ${a + 1} ${a + n + 2} ${a + n + 1}`);
  }
  return new TextEncoder().encode(lines.join("\n"));
}

test("a mesh of one's own is gripped and torn, and its scene text gives the same world", () => {
  const bytes = sheet(24);
  const world = engine.World.fromMesh("sheet.obj", bytes, "cm", [1, 1, 0]);
  assert.ok(world.isPlanar);
  const start = world.hash();
  assert.ok(world.cut([12, 15, 60], [0, 0, -1], [0.1, 0, -1]) > 5.9);
  world.grip([15, 16, 60], [0, 0, -1]);
  world.moveGrip([15, 26, 0]);
  world.step(60);
  assert.ok(world.measures().length_mm > 8, `${world.measures().length_mm}`);
  const twin = engine.world({ scene: world.sceneText, files: { "sheet.obj": bytes } });
  assert.equal(twin.hash(), start);
  world.free();
  twin.free();
});

test("a recording is repeated to the same hash, a spoilt one is refused", () => {
  const world = engine.world({ scene: "fig2-tear", byHand: true });
  world.step(2);
  world.record();
  const place = world.grip([13.5, 27.5, 60], [0, 0, -1]);
  world.moveGrip([place[0] - 5, place[1] - 3, 0]);
  world.step(20);
  const bytes = world.endRecording();
  assert.equal(world.endRecording(), undefined);
  assert.equal(engine.replay(bytes), world.hash());
  bytes[bytes.length - 9] ^= 1;
  assert.throws(() => engine.replay(bytes), /checksum/);
  world.free();
});
