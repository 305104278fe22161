// The hand: mouse, touch and keys become grips, drags, cuts and turns of the view.

/** Where the hand is in the picture, from −1 to 1 either way. */
const START = { x: 0, y: 0 };

export class HandInput {
  constructor(view, cursor, actions) {
    Object.assign(this, { view, cursor, actions, tool: "forceps", isPlanar: true, held: null, from: null, at: { ...START }, lift: 0, tip: -1 });
    const { canvas } = view;
    canvas.addEventListener("pointerdown", (event) => this.#down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", (event) => this.#up(event));
    canvas.addEventListener("keydown", (event) => this.#key(event));
    canvas.addEventListener("focus", () => this.#showCursor(canvas.matches(":focus-visible")));
    canvas.addEventListener("blur", () => this.#showCursor(false));
  }

  /** Forgets what it has in hand: another scene, another state. */
  forget() {
    Object.assign(this, { held: null, from: null, lift: 0 });
    this.view.showBlade(null);
    this.view.controls.enabled = true;
    this.view.canvas.classList.remove("held");
  }

  /** The engine has taken hold: states from now on tell whether it still does. */
  confirm() {
    if (this.held) this.held.isConfirmed = true;
  }

  setTool(tool) {
    this.tool = tool;
    this.view.canvas.classList.toggle("tool", tool !== "view");
  }

  #place(event) {
    const box = this.view.canvas.getBoundingClientRect();
    return { x: (2 * (event.clientX - box.left)) / box.width - 1, y: 1 - (2 * (event.clientY - box.top)) / box.height };
  }

  #down(event) {
    if (event.button !== 0 || this.tool === "view") return;
    const at = this.#place(event);
    const point = this.view.pick(at.x, at.y);
    if (!point) return;
    // What begins on the tissue is the tool's, what begins beside it turns the view.
    this.view.controls.enabled = false;
    this.view.canvas.setPointerCapture(event.pointerId);
    this.pointer = { id: event.pointerId, y: event.clientY };
    this.at = at;
    if (this.tool === "blade") this.#beginCut(at, point);
    else this.#grip(at, point);
  }

  #move(event) {
    if (this.pointer?.id !== event.pointerId) return;
    this.at = this.#place(event);
    if (this.from) return this.view.showBlade(this.from.point, this.view.onPlane(this.at.x, this.at.y, this.from.point, this.isPlanar));
    if (!this.held) return;
    if (event.shiftKey) this.lift += (this.pointer.y - event.clientY) * this.view.pixel(this.held.point);
    else this.held.target = this.view.onPlane(this.at.x, this.at.y, this.held.point, this.isPlanar) ?? this.held.target;
    this.pointer.y = event.clientY;
    this.#draw();
  }

  #up(event) {
    if (this.pointer?.id !== event.pointerId) return;
    this.pointer = null;
    if (this.from) this.#endCut();
    else this.#letGo();
  }

  #grip(at, point) {
    this.held = { point, target: point.clone() };
    this.lift = 0;
    this.view.canvas.classList.add("held");
    this.actions.grip(this.view.ray(at.x, at.y));
  }

  #letGo() {
    this.forget();
    this.actions.letGo();
  }

  #draw() {
    const { target } = this.held;
    this.actions.moveGrip([target.x, target.y, target.z + (this.isPlanar ? 0 : this.lift)]);
  }

  #beginCut(at, point) {
    this.from = { point, ray: this.view.ray(at.x, at.y) };
    this.view.showBlade(point, point);
  }

  #endCut() {
    const { ray } = this.from;
    const to = this.view.ray(this.at.x, this.at.y);
    this.forget();
    this.actions.cut({ origin: ray.origin, from: ray.direction, to: to.direction });
  }

  /** Puts the hand on a tear's tip, the next one each time. */
  goToTip(tips) {
    if (tips.length < 3) return false;
    this.tip = (this.tip + 1) % (tips.length / 3);
    const { x, y } = this.view.project(this.view.vector(tips.slice(3 * this.tip, 3 * this.tip + 3)));
    this.at = { x, y };
    this.#showCursor(true);
    return true;
  }

  #key(event) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const lift = { PageUp: 1, PageDown: -1 }[event.key];
    if (way) this.#step(way, event.shiftKey ? 5 : 1);
    else if (lift && this.held) { this.lift += lift * 8 * this.view.pixel(this.held.point); this.#draw(); }
    else if (event.key === "g" || event.key === "G") this.#toggleGrip();
    else if (event.key === "x" || event.key === "X") this.#toggleCut();
    else if (event.key === "t" || event.key === "T") this.actions.goToTip();
    else if (event.key === "q" || event.key === "Q") this.view.turn(-0.15);
    else if (event.key === "e" || event.key === "E") this.view.turn(0.15);
    else if (event.key === "+" || event.key === "=") this.view.zoom(0.9);
    else if (event.key === "-") this.view.zoom(1 / 0.9);
    else return;
    event.preventDefault();
    this.#showCursor(true);
  }

  /** Moves the hand by eight pixels times `size`. */
  #step([right, up], size) {
    const { clientWidth, clientHeight } = this.view.canvas;
    const within = (x) => Math.min(Math.max(x, -1), 1);
    this.at = { x: within(this.at.x + (16 * size * right) / clientWidth), y: within(this.at.y + (16 * size * up) / clientHeight) };
    if (this.from) this.view.showBlade(this.from.point, this.view.onPlane(this.at.x, this.at.y, this.from.point, this.isPlanar));
    if (!this.held) return;
    const [x, y] = this.view.axes();
    const pixels = 8 * size * this.view.pixel(this.held.point);
    this.held.target.addScaledVector(x, right * pixels).addScaledVector(y, up * pixels);
    this.#draw();
  }

  #toggleGrip() {
    if (this.held) return this.#letGo();
    const point = this.view.pick(this.at.x, this.at.y);
    if (point) this.#grip(this.at, point);
    else this.actions.say("There is no tissue under the hand.");
  }

  #toggleCut() {
    if (this.from) return this.#endCut();
    const point = this.view.pick(this.at.x, this.at.y);
    if (point) { this.#beginCut(this.at, point); this.actions.say("A cut begins here; X ends it."); }
    else this.actions.say("There is no tissue under the hand.");
  }

  #showCursor(isShown) {
    this.cursor.hidden = !isShown;
    this.cursor.style.left = `${50 * (this.at.x + 1)}%`;
    this.cursor.style.top = `${50 * (1 - this.at.y)}%`;
  }
}
