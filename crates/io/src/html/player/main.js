// The player: connects the views, the plots, the time line and the controls.
class Player {
  constructor(runs) {
    const at = (id) => document.getElementById(id);
    this.runs = runs;
    this.options = { wireframe: false, lattice: false, colliders: true, ground: true, volume: true };
    this.materials = new Materials();
    this.canvas = at("canvas");
    this.views = new Views(this.canvas, runs, this.materials);
    // All runs have one time line, that of the first one. A shorter run stays at its last frame.
    const frames = Math.max(...runs.map((run) => run.frames));
    this.clock = new Clock(frames, runs[0].fps / runs[0].every, () => this.invalidate());
    this.elements = Object.fromEntries(
      ["play", "frame", "time", "speed", "keys", "plots", "theme"].map((id) => [id, at(id)]),
    );
    const range = volumeRange(runs);
    this.plots = runs.map(
      (run) =>
        new Plot(run, range, frames, (frame) => {
          this.clock.setPlaying(false);
          this.clock.seek(frame);
        }),
    );
    this.elements.plots.append(...this.plots.map((plot) => plot.element));
    this.addLabels(at("labels"));
    this.connect(at);
    this.setTheme(document.documentElement.dataset.theme);
    listenToKeys(playerKeys(this), this.elements.keys.querySelector("dl"));
    this.isDrawn = false;
    const draw = (now) => {
      this.clock.advance(now);
      this.draw();
      requestAnimationFrame(draw);
    };
    requestAnimationFrame(draw);
  }

  // Labels the views if there are several.
  addLabels(labels) {
    if (this.runs.length < 2) return;
    labels.style.gridTemplate = `repeat(${this.views.rows}, 1fr) / repeat(${this.views.columns}, 1fr)`;
    for (const run of this.runs) {
      const label = document.createElement("div"),
        text = document.createElement("span");
      label.className = "label";
      text.textContent = run.name;
      label.append(text);
      labels.append(label);
    }
  }

  connect(at) {
    const { play, frame, speed, theme } = this.elements,
      { clock } = this;
    frame.max = String(clock.frames - 1);
    play.addEventListener("click", () => clock.setPlaying(!clock.isPlaying));
    const jump = (id, to) =>
      at(id).addEventListener("click", () => {
        clock.setPlaying(false);
        clock.seek(to);
      });
    jump("first", 0);
    jump("last", clock.frames - 1);
    frame.addEventListener("input", () => {
      clock.setPlaying(false);
      clock.seek(Number(frame.value));
    });
    speed.addEventListener("change", () => {
      clock.speed = Number(speed.value);
    });
    for (const option of Object.keys(this.options)) at(option).addEventListener("click", () => this.toggle(option));
    at("reset").addEventListener("click", () => this.resetCamera());
    at("help").addEventListener("click", () => this.showKeys());
    theme.addEventListener("click", () => this.toggleTheme());
    at("lattice").disabled = this.runs.every((run) => run.bodies.every((body) => body.lattice === 0));
    at("colliders").disabled = this.views.views.every((view) => view.colliders.every((collider) => collider.isFloor));
    for (const option of ["lattice", "colliders"]) {
      if (at(option).disabled) at(option).setAttribute("aria-pressed", "false");
    }
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) =>
      this.setTheme(event.matches ? "dark" : "light"),
    );
    this.views.controls.addEventListener("change", () => this.invalidate());
    new ResizeObserver(() => {
      this.views.resize();
      this.invalidate();
      // Drawn at once, so that a canvas of another size is not empty for a moment.
      this.draw();
    }).observe(this.canvas);
  }

  toggle(option) {
    const button = document.getElementById(option);
    if (button.disabled) return;
    this.options[option] = !this.options[option];
    button.setAttribute("aria-pressed", String(this.options[option]));
    if (option === "volume") this.elements.plots.hidden = !this.options.volume;
    if (option === "lattice") this.materials.setTransparent(this.options.lattice);
    for (const view of this.views.views) view.setVisible(this.options);
    this.invalidate();
  }

  toggleTheme() {
    this.setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  }

  setTheme(name) {
    document.documentElement.dataset.theme = name;
    this.materials.setTheme(THEMES[name]);
    this.views.setTheme(THEMES[name]);
    this.invalidate();
  }

  changeSpeed(steps) {
    const { speed } = this.elements;
    speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + steps, 0), speed.options.length - 1);
    speed.dispatchEvent(new Event("change"));
  }

  resetCamera() {
    this.views.resetCamera();
    this.invalidate();
  }

  showKeys() {
    this.elements.keys.showModal();
  }

  // Requests that everything is drawn again.
  invalidate() {
    this.isDrawn = false;
  }

  draw() {
    if (this.isDrawn) return;
    this.isDrawn = true;
    const { clock, runs, elements } = this,
      { frame } = clock,
      run = runs[0];
    for (const view of this.views.views) view.show(frame);
    this.views.draw();
    if (this.options.volume) for (const plot of this.plots) plot.draw(frame);
    const number = run.first + run.every * frame,
      last = run.first + run.every * (clock.frames - 1);
    const time = `${((frame * run.every) / run.fps).toFixed(2)} s`;
    elements.time.textContent = `Frame ${number} of ${last} · ${time}`;
    elements.frame.value = String(frame);
    elements.frame.setAttribute("aria-valuetext", `frame ${number} of ${last}, ${time}`);
    elements.play.classList.toggle("playing", clock.isPlaying);
    elements.play.setAttribute("aria-label", clock.isPlaying ? "Pause" : "Play");
  }
}

async function start() {
  const runs = [];
  for (const data of runData.splice(0)) runs.push(await readRun(data));
  const player = new Player(runs);
  // For scripts that drive the page.
  globalThis.player = player;
  showMessage("");
  document.documentElement.dataset.state = "ready";
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) player.clock.setPlaying(true);
}

start().catch((error) => fail("The page has failed: " + error.message + ". Reload it, or open it in another browser."));
