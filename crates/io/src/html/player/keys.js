// The keys: those of the list in the page.

// Returns the keys of a player, each with its names, its description and its action.
function playerKeys(player) {
  const { clock, views } = player;
  const step = (count) => () => {
    clock.setPlaying(false);
    clock.seek(clock.frame + count);
  };
  const to = (frame) => () => {
    clock.setPlaying(false);
    clock.seek(frame);
  };
  const turn =
    (...angles) =>
    () => {
      views.turn(...angles);
      player.invalidate();
    };
  return [
    [["Space"], "Play or pause", () => clock.setPlaying(!clock.isPlaying)],
    [["←"], "Frame before", step(-1)],
    [["→"], "Next frame", step(1)],
    [["Shift ←"], "Ten frames back", step(-10)],
    [["Shift →"], "Ten frames on", step(10)],
    [["Home"], "First frame", to(0)],
    [["End"], "Last frame", to(clock.frames - 1)],
    [["<", ","], "Slower", () => player.changeSpeed(-1)],
    [[">", "."], "Faster", () => player.changeSpeed(1)],
    [["W"], "Edges of the faces", () => player.toggle("wireframe")],
    [["L"], "Lattice", () => player.toggle("lattice")],
    [["C"], "Colliders", () => player.toggle("colliders")],
    [["G"], "Ground: planes, grid and shadows", () => player.toggle("ground")],
    [["V"], "Volume over time", () => player.toggle("volume")],
    [["A", "D"], "Turn the camera", null],
    [["A"], "", turn(-10, 0, 1)],
    [["D"], "", turn(10, 0, 1)],
    [["↑", "↓"], "Tilt the camera", null],
    [["↑"], "", turn(0, 8, 1)],
    [["↓"], "", turn(0, -8, 1)],
    [["+", "−"], "Zoom", null],
    [["+", "="], "", turn(0, 0, 1 / 1.15)],
    [["−", "-"], "", turn(0, 0, 1.15)],
    [["R"], "Move the camera back", () => player.resetCamera()],
    [["T"], "Light or dark", () => player.toggleTheme()],
    [["?"], "List the keys", () => player.showKeys()],
  ];
}

// Returns the name of the key of an event, as in the list.
function keyName(event) {
  const arrows = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", " ": "Space" };
  const name = arrows[event.key] ?? (event.key.length === 1 ? event.key.toUpperCase() : event.key);
  return event.shiftKey && (name === "←" || name === "→") ? `Shift ${name}` : name;
}

// Runs the actions of keys with their events, and fills the list of them.
function listenToKeys(keys, list) {
  const actions = new Map();
  for (const [names, description, action] of keys) {
    if (action) for (const name of names) actions.set(name, action);
    if (!description) continue;
    const term = document.createElement("dt"),
      text = document.createElement("dd");
    for (const name of names) {
      const key = document.createElement("kbd");
      key.textContent = name;
      term.append(key, " ");
    }
    text.textContent = description;
    list.append(term, text);
  }
  addEventListener("keydown", (event) => {
    const action = actions.get(keyName(event)),
      { target } = event;
    if (!action || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    // A list of choices uses letters and arrows, and a button the space bar and the enter key.
    const isPress = event.key === " " || event.key === "Enter";
    if (target instanceof HTMLSelectElement || (target instanceof HTMLButtonElement && isPress)) return;
    event.preventDefault();
    action(event);
  });
}
