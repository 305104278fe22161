// Runs of `plan.json` and `times.json`, as `tests/plan/mod.rs` does them natively.

/** Does an entry's steps by `step`; the world, to be freed. */
export function run(engine, { scene, steps, set, byHand, hand }, step = (world) => world.step(1)) {
  const world = engine.world({ scene, set, byHand });
  if (hand) {
    const place = world.grip(hand.origin, hand.direction);
    if (!place || !world.moveGrip(place.map((x, axis) => x + hand.by[axis]))) throw new Error("the ray meets no tissue");
  }
  for (let i = 0; i < steps; i++) step(world);
  return world;
}
