// A hand that closes a capsulorhexis by the calls that the page makes: after every grasp it takes the flap beside the tip, lifts it and draws it
// over along a circle about the pole, as the grips of the scene do.

/** The capsule of the page's list that keeps pace with a hand. */
export const CAPSULE = { scene: "capsulorhexis", set: ["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3"], byHand: true };

/** Steps: the pause between grasps, the lift, the arc. */
const [PAUSE, LIFT, ARC] = [20, 45, 405];
/** From the tip to the place of the grasp [mm], and where that is [°]: from inwards to backwards, the first that has tissue. */
const [REACH, WAYS] = [0.5, [45, 22, 0, -22, -45]];
/** How high [mm] and how far [rad] the flap is drawn. */
const [HEIGHT, ANGLE] = [0.5, (210 * Math.PI) / 180];
/** The most grasps. */
const GRASPS = 8;

const radius = ([x, y]) => Math.hypot(x, y);
const away = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
const turned = ([x, y, z], angle) => [x * Math.cos(angle) - y * Math.sin(angle), x * Math.sin(angle) + y * Math.cos(angle), z];

/** Takes hold beside a tip, in a view from above; the place. */
async function grasp(call, tip) {
  const inwards = [-tip[0] / radius(tip), -tip[1] / radius(tip), 0];
  for (const degrees of WAYS) {
    const [x, y] = turned(inwards, (degrees * Math.PI) / 180);
    const place = await call("grip", { origin: [tip[0] + REACH * x, tip[1] + REACH * y, 30], direction: [0, 0, -1] });
    if (place) return place;
  }
  throw new Error(`there is no tissue beside the tip at ${tip}`);
}

/** Grips and draws by `call(name, argument)` until the tear has ended or the grasps are used up; the course's figures. */
export async function close(call) {
  const tips = async () => {
    const all = await call("tips");
    return Array.from({ length: all.length / 3 }, (_, i) => Array.from(all.slice(3 * i, 3 * i + 3)));
  };
  const course = async () => (await call("measures")).bodies[0].course;
  // The tear begins on the circle, the puncture inside of it.
  let tip = (await tips()).sort((a, b) => radius(b) - radius(a))[0];
  const follow = async () => {
    tip = (await tips()).sort((a, b) => away(a, tip) - away(b, tip))[0] ?? tip;
  };
  for (let i = 0; i < GRASPS; i++) {
    await call("steps", PAUSE);
    // The tip has sprung back since the flap was let go.
    await follow();
    const place = await grasp(call, tip);
    for (let step = 1; step <= LIFT + ARC; step++) {
      const [up, round] = [Math.min(step / LIFT, 1), Math.max(step - LIFT, 0) / ARC];
      await call("moveGrip", turned([place[0], place[1], place[2] + HEIGHT * up], ANGLE * round));
      await call("steps", 1);
      if (step % 10) continue;
      if ((await course()).outcome !== "unfinished") return course();
      await follow();
    }
    await call("letGo");
  }
  return course();
}
