// The figures beside the picture.

const element = (id) => document.getElementById(id);
const BUDGET = 1000 / 60;

function set(id, text) {
  const node = element(id);
  if (node.textContent !== text) node.textContent = text;
}

function force(newtons) {
  const size = Math.abs(newtons);
  return size >= 0.1 ? `${newtons.toFixed(3)} N` : `${(1e3 * newtons).toFixed(2)} mN`;
}

const or = (value, unit, digits) => (value === null ? "–" : `${value.toFixed(digits)}${unit}`);

/** Shows the figures of a state. */
export function showMeasures(m, stepTime, picturesPerSecond) {
  set("r-hand", force(m.hand_n));
  set("r-force", force(m.force_n));
  set("r-length", `${m.length_mm.toFixed(3)} mm`);
  set("r-tips", `${m.tips}, ${m.criterion.toFixed(2)}`);
  set("r-time", `${(m.simulated_ms / 1000).toFixed(2)} s, step ${m.steps}`);
  set("r-triangles", m.bodies.reduce((sum, body) => sum + body.triangles, 0).toLocaleString("en"));
  set("r-hash", m.hash);
  set("r-fps", picturesPerSecond === null ? "–" : `${picturesPerSecond.toFixed(0)} per s`);
  const time = stepTime ?? 0;
  set("r-step", stepTime === null ? "–" : `${time.toFixed(1)} of ${BUDGET.toFixed(1)} ms`);
  const meter = element("budget");
  meter.setAttribute("aria-valuenow", Math.min(time, BUDGET).toFixed(1));
  meter.setAttribute("aria-valuetext", `${time.toFixed(1)} of ${BUDGET.toFixed(1)} milliseconds`);
  meter.classList.toggle("over", time > BUDGET);
  element("budget-bar").style.width = `${Math.min(time / BUDGET, 1) * 100}%`;
  showCourse(m.bodies.find((body) => body.course)?.course);
}

const OUTCOMES = { closed: "closed", ran_out: "ran out to the rim", torn_off: "flap torn off", unfinished: "unfinished" };

function showCourse(course) {
  element("course").hidden = !course;
  if (!course) return;
  set("c-outcome", OUTCOMES[course.outcome]);
  set("c-completion", `${course.completion_deg.toFixed(0)}°`);
  set("c-diameter", or(course.diameter_mm, " mm", 3));
  set("c-circularity", or(course.circularity, "", 3));
  set("c-decentration", or(course.decentration_mm, " mm", 3));
  set("c-radius", `${course.largest_radius_mm.toFixed(3)} mm`);
  set("c-grasps", String(course.grasps));
  set("c-force", `${force(course.force_rms_n)}, ${force(course.force_peak_n)}`);
}
