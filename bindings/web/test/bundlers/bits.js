/** The square torn by hand: module, hash of the state, and a digest of the positions' bytes. */
export async function bitsOf(engine) {
  const world = engine.world({ scene: "fig2-tear", byHand: true });
  const place = world.grip([13.5, 27.5, 60], [0, 0, -1]);
  world.moveGrip([place[0] - 9, place[1] - 6, 0]);
  world.step(60);
  const { hash, length_mm } = world.measures();
  const digest = await crypto.subtle.digest("SHA-256", world.positions());
  world.free();
  const positions = [...new Uint8Array(digest)].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  return { flavour: engine.flavour, hash, length_mm, positions };
}
