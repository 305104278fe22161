// The page: chooses scenes, lets the engine run and shows what it says.

import { EngineProxy } from "./engine.js";
import { View } from "./view.js";
import { HandInput } from "./hand.js";
import { showMeasures } from "./readouts.js";
import { gradient, roundHigh } from "./colours.js";

const element = (id) => document.getElementById(id);
/** Scenes to tear by hand. A coarse capsule keeps pace with the hand. */
const BY_HAND = [
  { value: "fig2-tear", label: "Fibrous square with a notch", scene: "fig2-tear" },
  {
    value: "capsule-coarse", label: "Lens capsule, 1,500 triangles", scene: "capsulorhexis",
    set: ["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3"],
  },
  { value: "capsulorhexis", label: "Lens capsule, 5,000 triangles", scene: "capsulorhexis" },
];
const MESHES = /\.(obj|stl|ply|off|vtk|vtu|vtp|msh|glb|gltf)$/i;

const state = { isPlaying: false, isStale: true, isAsking: false, high: 1e-3, shade: "stress", about: null, opened: null, last: null };
const view = new View(element("stage"));
const engine = new EngineProxy(restart);
let catalog = [];

function say(text, isError = false) {
  element("status").textContent = text;
  element("status").classList.toggle("error", isError);
}

const complain = (error) => say(error.message, true);

const hand = new HandInput(view, element("cursor"), {
  say,
  async grip(ray) {
    const place = await engine.call("grip", ray).catch(complain);
    if (!place) return hand.forget();
    hand.confirm();
    play(true);
    say("Gripped: draw it.");
  },
  moveGrip: (target) => engine.call("moveGrip", target).catch(complain),
  async letGo() { await engine.call("letGo").catch(complain); say("Let go."); state.isStale = true; },
  async cut(rays) {
    const made = await engine.call("cut", rays).catch(complain);
    if (made !== undefined) say(`Cut ${made.toFixed(2)} mm.`);
    state.isStale = true;
  },
  goToTip: () => say(hand.goToTip(state.last?.tips ?? []) ? "The hand is at a tip." : "There is no tip."),
});

/** Opens a scene of the catalog, a text or a mesh; the state before is gone. */
async function open(opened) {
  play(false);
  hand.forget();
  say("Building the scene …");
  try {
    const { mesh, ...options } = opened;
    // The bytes stay here, for a reset after a fault.
    state.about = mesh ? await engine.call("openMesh", mesh) : await engine.call("open", options);
  } catch (error) {
    complain(error);
    return false;
  }
  state.opened = opened;
  state.recording = false;
  hand.isPlanar = state.about.isPlanar;
  await frame(0);
  state.high = state.shade === "criterion" ? 1 : 1e-3;
  view.fit(state.last.positions, state.about.isPlanar);
  element("text").value = state.about.text ?? catalog.find((entry) => entry.name === opened.scene)?.text ?? opened.scene ?? "";
  say(`${state.about.name}: ready.`);
  return true;
}

/** The worker has broken: the scene begins anew. */
async function restart() {
  await engine.call("start").catch(complain);
  if (state.opened && (await open(state.opened))) say("The engine had to be started anew; the scene is at its beginning.", true);
}

async function openChosen() {
  const { value } = element("scene");
  if (value === "own") return;
  const { scene, set = [] } = BY_HAND.find((entry) => entry.value === value) ?? { scene: value };
  const isByHand = !element("scripted").checked;
  element("about").textContent = catalog.find((entry) => entry.name === scene)?.about ?? "";
  if (await open({ scene, set, byHand: isByHand })) {
    if (isByHand) say("Drag the tissue beside a tip to tear it.");
    play(isByHand);
  }
}

async function openMesh(name, bytes) {
  const angle = (Number(element("angle").value) * Math.PI) / 180;
  const mesh = { name, bytes, unit: element("unit").value, fibres: [Math.cos(angle), Math.sin(angle), 0] };
  if (await open({ mesh })) {
    ownScene(name);
    play(true);
    say(`${name}: drag it; or cut a slit with the blade and tear from there.`);
  }
}

function ownScene(name) {
  const select = element("scene");
  select.querySelector("option[value=own]")?.remove();
  select.append(new Option(name, "own", true, true));
  element("about").textContent = "";
}

async function openFile(file) {
  if (!file) return;
  if (file.name.toLowerCase().endsWith(".toml")) {
    if (await open({ scene: `${await file.text()}\n` })) ownScene(file.name);
  } else if (file.name.toLowerCase().endsWith(".rec")) {
    await replay(file);
  } else if (MESHES.test(file.name)) {
    await openMesh(file.name, new Uint8Array(await file.arrayBuffer()));
  } else {
    say(`${file.name}: give a mesh (.obj, .stl, .ply, .off, .vtk, .vtu, .vtp, .msh, .glb, .gltf) a scene (.toml) or a recording (.rec).`, true);
  }
}

/** Repeats a recording of the page; what is open stays as it is. */
async function replay(file) {
  play(false);
  say(`${file.name}: repeating …`);
  const hash = await engine.call("replay", new Uint8Array(await file.arrayBuffer())).catch(complain);
  if (hash) say(`${file.name}: repeated to the same hash ${hash}.`);
}

function play(isPlaying) {
  state.isPlaying = isPlaying;
  element("play").textContent = isPlaying ? "Pause" : "Play";
  element("play").setAttribute("aria-pressed", String(isPlaying));
  state.pictures = [];
}

/** Asks for the next state and shows it. */
async function frame(steps) {
  state.isAsking = true;
  state.isStale = false;
  try {
    const next = await engine.call("frame", { steps, shade: state.shade, fibres: element("fibres").checked });
    state.last = next;
    shown(next);
  } catch (error) {
    play(false);
    complain(error);
  } finally {
    state.isAsking = false;
  }
}

function shown(next) {
  if (next.stepTime !== null) state.stepTime = 0.8 * (state.stepTime ?? next.stepTime) + 0.2 * next.stepTime;
  const high = state.shade === "criterion" ? 1 : roundHigh(next.values);
  // The scale grows at once and shrinks only where it is much too large.
  if (high > state.high || high < state.high / 4 || state.shade === "criterion") state.high = high;
  element("legend-high").textContent = Number(state.high.toPrecision(1)).toString();
  view.show(next, state.high, state.about.jawRadius);
  element("undo").disabled = next.undoCount === 0;
  if (hand.held?.isConfirmed && !next.place) { hand.forget(); say("The jaws have lost their hold."); }
  tell(next);
  showMeasures(next.measures, state.stepTime ?? null, rate());
}

function tell({ fault, events, measures }) {
  if (fault) { play(false); return say(fault, true); }
  if (events.some(({ what }) => what.startsWith("FragmentFreed"))) say("A piece has come free.");
  else if (events.some(({ what }) => what.startsWith("Ended"))) say("A tear has reached its end.");
  const isDone = measures.is_finished && state.opened && !state.opened.mesh && !state.opened.byHand;
  if (isDone && state.isPlaying) { play(false); say("The scene is at its end."); }
}

/** Pictures in the last second. */
function rate() {
  if (!state.isPlaying) return null;
  const now = performance.now();
  state.pictures.push(now);
  while (state.pictures[0] < now - 1000) state.pictures.shift();
  const span = now - state.pictures[0];
  return span > 200 ? (1000 * (state.pictures.length - 1)) / span : null;
}

function loop() {
  requestAnimationFrame(loop);
  if (!state.isAsking && state.last && (state.isPlaying || state.isStale)) frame(state.isPlaying ? 1 : 0);
  view.render();
}

async function command(call) {
  hand.forget();
  const done = await engine.call(call).catch(complain);
  if (call === "undo") say(done ? "One step back." : "There is nothing to undo.");
  if (call === "reset") say("At the beginning.");
  state.isStale = true;
}

async function record() {
  const button = element("record");
  if (!state.recording) {
    await engine.call("record").catch(complain);
    state.recording = true;
    say("Recording every call from here on.");
  } else {
    state.recording = false;
    const bytes = await engine.call("endRecording").catch(complain);
    if (bytes) save(bytes, `${state.about.name}.rec`);
    say(bytes ? "Saved: open it here and it is repeated." : "There was no recording.");
  }
  button.textContent = state.recording ? "End and save the recording" : "Record from now";
  button.setAttribute("aria-pressed", String(state.recording));
}

function save(bytes, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([bytes], { type: "application/octet-stream" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

function listen() {
  const on = (id, event, act) => element(id).addEventListener(event, act);
  on("play", "click", () => play(!state.isPlaying));
  on("step", "click", () => { play(false); if (!state.isAsking) frame(1); });
  on("undo", "click", () => command("undo"));
  on("reset", "click", () => command("reset"));
  on("record", "click", record);
  on("scene", "change", openChosen);
  on("scripted", "change", openChosen);
  on("file", "change", (event) => openFile(event.target.files[0]));
  on("run-text", "click", async () => {
    const files = state.opened?.mesh ? { [state.opened.mesh.name]: state.opened.mesh.bytes } : state.opened?.files ?? {};
    if (await open({ scene: `${element("text").value}\n`, files, byHand: false })) play(true);
  });
  on("fibres", "change", () => { state.isStale = true; });
  on("tips", "change", ({ target }) => { view.tips.visible = view.directions.visible = target.checked; view.isStale = true; });
  on("obstacles", "change", ({ target }) => { view.obstacles.visible = target.checked; view.isStale = true; });
  on("mesh", "change", ({ target }) => { view.wires.visible = target.checked; view.isStale = true; });
  document.querySelectorAll("input[name=tool]").forEach((radio) => radio.addEventListener("change", () => hand.setTool(radio.value)));
  document.querySelectorAll("input[name=shade]").forEach((radio) => radio.addEventListener("change", () => {
    state.shade = radio.value;
    element("legend-unit").textContent = radio.value === "stress" ? "MPa" : "tears above 1";
    state.high = radio.value === "criterion" ? 1 : 1e-3;
    state.isStale = true;
  }));
  hand.setTool("forceps");
  document.addEventListener("keydown", keys);
  dropping();
}

/** Keys that hold everywhere, but for where one writes. */
function keys(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("input, select, textarea, button, summary, a")) return;
  const act = { " ": () => play(!state.isPlaying), ".": () => element("step").click(), z: () => command("undo"), r: () => command("reset") };
  const chosen = act[event.key.toLowerCase()];
  if (!chosen) return;
  event.preventDefault();
  chosen();
}

function dropping() {
  const show = (isShown) => { element("drop").hidden = !isShown; };
  document.addEventListener("dragover", (event) => { event.preventDefault(); show(true); });
  document.addEventListener("dragleave", (event) => { if (!event.relatedTarget) show(false); });
  document.addEventListener("drop", (event) => { event.preventDefault(); show(false); openFile(event.dataTransfer.files[0]); });
}

function fillScenes() {
  const select = element("scene");
  const group = (label, options) => {
    const node = document.createElement("optgroup");
    node.label = label;
    node.append(...options);
    select.append(node);
  };
  const isOther = ({ name }) => !BY_HAND.some(({ value }) => value === name);
  group("To tear by hand", BY_HAND.map(({ label, value }) => new Option(label, value)));
  group("More of the catalog", catalog.filter(isOther).map(({ name }) => new Option(name, name)));
}

/** What `rhexis view SCENE` serves beside the page. */
async function openServed(address) {
  const base = new URL(address, location.href);
  const ask = async (path) => {
    const response = await fetch(new URL(path, base));
    if (!response.ok) throw new Error(await response.text());
    return response;
  };
  const { scene, set, files, mesh } = await (await ask(base)).json();
  const read = async (path) => new Uint8Array(await (await ask(path)).arrayBuffer());
  if (mesh) return openMesh(mesh.name, await read(mesh.at));
  const contents = await Promise.all(files.map(async ({ name, at }) => [name, await read(at)]));
  element("scripted").checked = true;
  if (await open({ scene, set, files: Object.fromEntries(contents) })) ownScene(state.about.name);
}

async function main() {
  element("legend-bar").style.background = gradient();
  listen();
  const query = new URLSearchParams(location.search);
  const simd = { plain: false, simd: true }[query.get("module")];
  const started = await engine.call("start", simd === undefined ? {} : { simd });
  catalog = started.catalog;
  fillScenes();
  requestAnimationFrame(loop);
  if (query.has("start")) await openServed(query.get("start"));
  else {
    const asked = query.get("scene");
    if ([...element("scene").options].some(({ value }) => value === asked)) element("scene").value = asked;
    element("scripted").checked = query.has("scripted");
    await openChosen();
  }
  document.documentElement.dataset.ready = started.flavour;
}

// What a test or a curious reader may ask from the console.
window.rhexis = { call: (call, argument) => engine.call(call, argument), state, view, hand, play, open, openFile };

main().catch(complain);
