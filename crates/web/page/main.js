// The page: connects the controls, the picture and the simulation.

/* global fail, listenToKeys, showMessage */

import { Drags } from "./drag.js";
import { Figures } from "./figures.js";
import { pageKeys } from "./keys.js";
import { FRAME } from "./pace.js";
import { LiveBody, Picture } from "./picture.js";
import { Simulation } from "./simulation.js";

const at = (id) => document.getElementById(id);

// Shipped shapes: names and files.
const SHAPES = [
  ["Bust", "shapes/bust.obj"],
  ["Ball", "shapes/ball.obj"],
  ["Bar", "shapes/bar.obj"],
  ["Ring", "shapes/ring.obj"],
];

// Settings with a slider.
const SLIDERS = ["poisson", "inflate", "wind", "grip"];

// Longest time between two pictures that counts, in seconds: a page in the background is not drawn.
const LONGEST = 0.25;

class Page {
  constructor() {
    this.simulation = new Simulation();
    this.figures = new Figures(at);
    this.picture = null;
    this.source = null;
    // The last settings that the simulation took.
    this.applied = null;
    // Poisson's ratio that was chosen; null: the one of the material.
    this.poisson = null;
    this.isPaused = false;
    this.isAtRest = false;
    this.isAsked = false;
    this.buffer = null;
    this.last = performance.now();
    this.fillShapes();
    this.connect();
    listenToKeys(pageKeys(this, at), at("keys").querySelector("dl"));
  }

  async start() {
    await this.simulation.start();
    this.firstLoad = this.loadShape(SHAPES[0][1]);
    await this.firstLoad;
    const draw = (now) => {
      if (this.picture) this.tick(now);
      requestAnimationFrame(draw);
    };
    requestAnimationFrame(draw);
  }

  // Returns the settings as the simulation takes them.
  settings() {
    const isPressed = (id) => at(id).getAttribute("aria-pressed") === "true";
    return {
      resolution: Number(at("resolution").value),
      gravity: Number(at("gravity").value),
      material: at("material").value,
      poisson: this.poisson,
      inflate: Number(at("inflate").value),
      wind: Number(at("wind").value),
      grip: Number(at("grip").value),
      up: at("up").value,
      volume: isPressed("volume"),
      floor: isPressed("floor"),
      base: isPressed("base"),
    };
  }

  // Puts the controls back to the last settings that the simulation took.
  restoreControls() {
    if (!this.applied) return;
    this.poisson = this.applied.poisson;
    for (const id of ["resolution", "gravity", "material", "up", ...SLIDERS]) at(id).value = this.applied[id];
    this.showNumbers();
    for (const id of ["volume", "floor", "base"]) at(id).setAttribute("aria-pressed", String(this.applied[id]));
    this.picture?.set({ ground: this.applied.floor });
  }

  // Remembers the settings that the simulation took, and shows the Poisson's ratio of the material.
  keep(settings, { poisson }) {
    this.applied = { ...settings, poisson };
    if (this.poisson === null) at("poisson").value = poisson;
    this.showNumbers();
  }

  // Shows the numbers of the sliders.
  showNumbers() {
    for (const id of SLIDERS) at(id).nextElementSibling.textContent = Number(at(id).value).toFixed(2);
  }

  fillShapes() {
    for (const [name, path] of SHAPES) at("shape").append(new Option(name, path));
  }

  connect() {
    const on = (id, action) =>
      at(id).addEventListener(at(id) instanceof HTMLButtonElement ? "click" : "change", action);
    on("shape", () => this.loadShape(at("shape").value));
    on("open", () => at("file").click());
    on("file", () => {
      const [file] = at("file").files;
      if (file) this.loadFile(file);
      at("file").value = "";
    });
    on("gravity", () => this.apply(false));
    on("material", () => {
      this.poisson = null;
      this.apply(false);
    });
    for (const id of SLIDERS) this.connectSlider(id);
    for (const id of ["up", "resolution"]) on(id, () => this.apply(true));
    for (const id of ["volume", "floor", "base"]) on(id, () => this.toggle(id));
    for (const id of ["wireframe", "lattice"]) on(id, () => this.toggle(id));
    on("pause", () => this.toggle("pause"));
    on("reset", () => this.reset());
    on("camera", () => this.picture?.views.resetCamera());
    on("theme", () => this.setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
    on("help", () => at("keys").showModal());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) =>
      this.setTheme(event.matches ? "dark" : "light"),
    );
    this.connectDrop();
  }

  connectSlider(id) {
    const slider = at(id);
    slider.addEventListener("input", () => {
      if (id === "poisson") this.poisson = Number(slider.value);
      this.showNumbers();
      this.apply(false);
    });
    // Arrows move the slider, and neither the camera nor the body.
    slider.addEventListener("keydown", (event) => {
      if (event.key.startsWith("Arrow")) event.stopPropagation();
    });
  }

  connectDrop() {
    const hasFile = (event) => [...(event.dataTransfer?.types ?? [])].includes("Files");
    addEventListener("dragover", (event) => {
      if (!hasFile(event)) return;
      event.preventDefault();
      at("drop").classList.add("over");
    });
    addEventListener("dragleave", (event) => {
      if (!event.relatedTarget) at("drop").classList.remove("over");
    });
    addEventListener("drop", (event) => {
      at("drop").classList.remove("over");
      if (!hasFile(event)) return;
      event.preventDefault();
      const [file] = event.dataTransfer.files;
      if (file) this.loadFile(file);
    });
  }

  // Presses a button that stays pressed, or lets it go.
  toggle(id) {
    const button = at(id),
      isPressed = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(isPressed));
    if (id === "pause") this.isPaused = isPressed;
    else if (id === "wireframe" || id === "lattice") this.picture?.set({ [id]: isPressed });
    else this.apply(false);
    if (id === "floor") this.picture?.set({ ground: isPressed });
  }

  setTheme(name) {
    document.documentElement.dataset.theme = name;
    this.picture?.setTheme(name);
  }

  async loadShape(path) {
    let bytes;
    try {
      const response = await fetch(path);
      if (!response.ok) throw new Error(`${response.status} ${response.statusText}`);
      bytes = await response.arrayBuffer();
    } catch (error) {
      showMessage(`${path} cannot be read: ${error.message}`, true);
      return;
    }
    at("up").value = "y";
    await this.load(path.split("/").pop(), bytes);
  }

  async loadFile(file) {
    // A folder, or a file that was removed, has no bytes.
    const bytes = await file.arrayBuffer().catch(() => null);
    if (!bytes) {
      showMessage(`${file.name} cannot be read; drop an OBJ, GLB, glTF, STL or PLY file`, true);
      return;
    }
    if (!(await this.load(file.name, bytes))) return;
    at("shape").querySelector("[data-own]")?.remove();
    const option = new Option(file.name, "", true, true);
    option.dataset.own = "";
    option.disabled = true;
    at("shape").append(option);
  }

  // Shows a model. Returns whether it is one.
  async load(name, bytes) {
    showMessage(`Building ${name} …`);
    this.drags?.clear();
    const settings = this.settings(),
      answer = await this.ask("load", { name, bytes, settings });
    if (!answer) {
      this.restoreControls();
      return false;
    }
    this.source = { name, bytes };
    this.keep(settings, answer);
    this.showBody(answer, true);
    showMessage("");
    return true;
  }

  // Applies the settings.
  async apply(isRebuilt) {
    await this.firstLoad;
    if (!this.picture) return;
    if (isRebuilt) {
      showMessage("Building …");
      this.drags?.clear();
    }
    const settings = this.settings(),
      answer = await this.ask("apply", { settings, isRebuilt });
    if (!answer) {
      this.restoreControls();
      return;
    }
    this.keep(settings, answer);
    if (!isRebuilt) return;
    this.showBody(answer);
    showMessage("");
  }

  async reset() {
    if (!this.picture) return;
    this.drags.clear();
    const answer = await this.ask("reset");
    if (answer) this.showBody(answer);
  }

  // Asks the simulation, and shows its message if it refuses. Returns its answer, or nothing.
  async ask(kind, message, transfer) {
    // The new simulation has no body yet.
    if (this.isRestarting) return null;
    try {
      return await this.simulation.ask(kind, message, transfer);
    } catch (error) {
      if (error.isFatal) await this.restart(error);
      else showMessage(error.message, true);
      return null;
    }
  }

  // Starts the simulation again, with the last model that was shown and the last settings that it took. Several
  // requests can fail at once.
  async restart(error) {
    if (this.isRestarting) return;
    this.isRestarting = true;
    try {
      await this.simulation.start();
      if (this.source) {
        const answer = await this.simulation.ask("load", { ...this.source, settings: this.applied });
        this.restoreControls();
        this.showBody(answer);
      }
    } finally {
      this.isRestarting = false;
    }
    showMessage(`The simulation has failed, and was started again: ${error.message}`, true);
  }

  showBody(answer, isOtherShape = false) {
    const body = new LiveBody(answer);
    if (this.picture) {
      this.drags.clear();
      this.picture.setBody(body, isOtherShape);
    } else {
      this.picture = new Picture(at("canvas"), body);
      this.drags = new Drags(
        this.picture,
        (kind, message) => {
          at("hint").classList.add("done");
          this.ask(kind, message);
        },
        () => this.settings().floor,
      );
    }
    this.buffer = null;
    this.figures.showBody(body);
    this.showVolume(answer);
    document.documentElement.dataset.state = "ready";
  }

  // Takes part in each picture of the screen.
  tick(now) {
    if (!this.isAsked) this.advance(now);
    if (this.hasDrawn) this.picture.adapt(now - this.lastTick);
    const begin = performance.now();
    this.lastTick = now;
    this.hasDrawn = this.picture.draw();
    if (this.hasDrawn) this.figures.addDrawing(performance.now() - begin);
    const { isPaused, isAtRest, picture } = this;
    this.figures.update({ isPaused, isAtRest, isReduced: picture.quality > 0, frame: FRAME });
  }

  // Asks for the next frame, and shows it when it is there. One request is under way at a time.
  async advance(now) {
    this.isAsked = true;
    const passed = (now - this.last) / 1000,
      elapsed = this.isPaused ? 0 : Math.min(passed, LONGEST);
    this.last = now;
    const buffer = this.buffer,
      { body } = this.picture;
    this.buffer = null;
    const drags = this.drags.displacements();
    const answer = await this.ask("frame", { elapsed, drags, buffer }, buffer ? [buffer] : []);
    this.isAsked = false;
    if (!answer) return;
    this.isAtRest = answer.isAtRest;
    this.figures.addFrame(answer, elapsed);
    this.buffer = answer.returned ?? null;
    // Another body may be shown by now.
    if (!answer.buffer || body !== this.picture.body) return;
    this.buffer = body.buffer;
    body.take(answer);
    this.picture.show();
    this.showVolume(answer);
  }

  // The volume of a closed mesh is that of the triangles that are drawn, computed independently of the simulation.
  showVolume(answer) {
    const { picture, figures } = this;
    // A closed sheet without thickness has no volume of its own; that of the cells is shown.
    const hasVolume = picture.body.isClosed && Math.abs(picture.restVolume) > 1e-9;
    figures.showVolume(hasVolume ? { ...answer, volumeError: picture.volumeError() } : answer);
  }
}

// Where start.js has found that the page cannot run, its message stays.
if (document.documentElement.dataset.state !== "failed") {
  // For scripts that drive the page.
  globalThis.page = new Page();
  globalThis.page
    .start()
    .catch((error) => fail(`The page has failed: ${error.message}. Reload it, or open it in another browser.`));
}
