// Pointers and keys that pull the body.

// Number of the keyboard among the pointers. Browsers give -1 to no pointing device.
const KEYBOARD = -1;

// Way of the grabbed part for one press of an arrow key, in m.
const KEY_STEP = 0.04;

// Lowest height of a grabbed point above the floor, in m.
const LOWEST = 0.01;

export class Drags {
  // `send` asks the simulation to do something: see worker.js.
  constructor(picture, send, hasFloor) {
    Object.assign(this, { picture, send, hasFloor });
    // For each pointer the grabbed point, and the point that it is pulled to.
    this.held = new Map();
    const { canvas } = picture,
      area = canvas.parentElement;
    // Before the controls of the camera, which listen to the canvas, get the event.
    area.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(name, (event) => this.release(event.pointerId));
    }
  }

  down(event) {
    const { canvas } = this.picture;
    if (event.target !== canvas || event.button !== 0) return;
    const hit = this.picture.pick(event);
    if (!hit) return;
    event.stopPropagation();
    event.preventDefault();
    canvas.focus({ preventScroll: true, focusVisible: false });
    canvas.setPointerCapture(event.pointerId);
    this.grab(event.pointerId, hit);
  }

  grab(pointer, { point, start }) {
    this.held.set(pointer, { from: point.clone(), to: point.clone() });
    this.send("grab", { pointer, point: start });
    this.show(pointer);
  }

  move(event) {
    const held = this.held.get(event.pointerId);
    if (held) this.pull(event.pointerId, this.picture.inPlane(event, held.from));
  }

  pull(pointer, to) {
    const held = this.held.get(pointer);
    held.to.copy(to);
    if (this.hasFloor()) held.to.y = Math.max(held.to.y, Math.min(held.from.y, LOWEST));
    this.show(pointer);
  }

  release(pointer) {
    if (!this.held.delete(pointer)) return;
    this.send("release", { pointer });
    this.picture.mark(pointer, null);
    this.picture.canvas.classList.toggle("dragging", this.held.size > 0);
  }

  // Lets all pointers go.
  clear() {
    for (const pointer of [...this.held.keys()]) this.release(pointer);
  }

  show(pointer) {
    this.picture.mark(pointer, this.held.get(pointer).to);
    this.picture.canvas.classList.add("dragging");
  }

  // Returns the displacements of the grabbed parts, as the simulation takes them.
  displacements() {
    return [...this.held].map(([pointer, { from, to }]) => [pointer, to.clone().sub(from).toArray()]);
  }

  // Grabs the top of the body with the keyboard, or lets go.
  toggleKeyboard() {
    if (this.held.has(KEYBOARD)) this.release(KEYBOARD);
    else this.grab(KEYBOARD, this.picture.pickTop());
  }

  // Pulls with the keyboard, in steps to the right and up. Returns whether it holds anything.
  pullByKeys(right, up) {
    const held = this.held.get(KEYBOARD);
    if (held) this.pull(KEYBOARD, held.to.clone().add(this.picture.across(KEY_STEP * right, KEY_STEP * up)));
    return held !== undefined;
  }
}
