// The engine's worker: steps and answers, one call after the other.

import { load } from "../index.js";

let engine, world;

function replace(next) {
  world?.free();
  world = next;
  return about();
}

function about() {
  return { name: world.name, isPlanar: world.isPlanar, dt: world.dt, jawRadius: world.jawRadius, text: world.sceneText };
}

/** What a picture needs. */
function picture({ shade, fibres }) {
  const obstacles = world.obstacles();
  const arrays = {
    positions: world.positions(), indices: world.indices(), values: world.vertexValues(shade),
    fibres: fibres ? world.fibres() : new Float32Array(), tips: world.tips(), tipDirections: world.tipDirections(),
    grips: world.grips(), solids: obstacles.positions, solidIndices: obstacles.indices,
  };
  return { ...arrays, place: world.gripPlace(), undoCount: world.undoCount };
}

const calls = {
  async start(options) {
    engine = await load(options);
    return { catalog: engine.catalog(), version: engine.version(), flavour: engine.flavour };
  },
  open: (options) => replace(engine.world(options)),
  openMesh: ({ name, bytes, unit, fibres }) => replace(engine.World.fromMesh(name, bytes, unit, fibres)),
  frame({ steps, shade, fibres }) {
    const begin = performance.now();
    let fault = null;
    try {
      if (steps) world.step(steps);
    } catch (error) {
      if (error instanceof WebAssembly.RuntimeError) throw error;
      fault = error.message;
    }
    const stepTime = steps ? (performance.now() - begin) / steps : null;
    const events = world.events();
    return { stepTime, fault, events, ...picture({ shade, fibres }), measures: world.measures() };
  },
  steps: (count) => world.step(count),
  hash: () => world.hash(),
  measures: () => world.measures(),
  tips: () => world.tips(),
  grip: ({ origin, direction }) => world.grip(origin, direction) ?? null,
  moveGrip: (target) => world.moveGrip(target),
  letGo: () => world.letGo(),
  cut: ({ origin, from, to }) => world.cut(origin, from, to),
  undo: () => world.undo(),
  reset: () => world.reset(),
  record: () => world.record(),
  endRecording: () => world.endRecording() ?? null,
  replay: (bytes) => engine.replay(bytes),
};

function buffers(value) {
  if (!value || typeof value !== "object") return [];
  return Object.values(value).filter(ArrayBuffer.isView).map((array) => array.buffer);
}

/** Calls are answered in their order, loading included. */
let queue = Promise.resolve();

self.onmessage = ({ data: { id, call, argument } }) => {
  queue = queue.then(async () => {
    try {
      const value = await calls[call](argument);
      self.postMessage({ id, value }, buffers(value));
    } catch (error) {
      // A module that has trapped is not to be trusted any more.
      const isBroken = error instanceof WebAssembly.RuntimeError;
      self.postMessage({ id, error: String(error.message ?? error), isBroken });
    }
  });
};
