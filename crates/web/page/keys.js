// The keys: those of the list in the page.

// Returns the keys of the page, each with its names, its description and its action.
export function pageKeys(page, at) {
  // A key that is held down repeats only what turns, pulls and zooms.
  const once = (action) => (event) => {
    if (!event.repeat) action();
  };
  const press = (id) => once(() => at(id).click());
  const turn =
    (...angles) =>
    () =>
      page.picture?.views.turn(...angles);
  const arrow = (right, up) => () => {
    if (!page.drags?.pullByKeys(right, up)) page.picture?.views.turn(-8 * right, 8 * up, 1);
  };
  return [
    [["Space"], "Pause or go on", press("pause")],
    [["R"], "Put the body back", press("reset")],
    [["V"], "Preserve the volume", press("volume")],
    [["B"], "Hold the base", press("base")],
    [["F"], "Floor", press("floor")],
    [["O"], "Open a model", press("open")],
    [["Enter"], "Grab the top of the body, or let go", once(() => page.drags?.toggleKeyboard())],
    [["←", "→", "↑", "↓"], "Pull the grabbed part, or turn the camera", null],
    [["←"], "", arrow(-1, 0)],
    [["→"], "", arrow(1, 0)],
    [["↑"], "", arrow(0, 1)],
    [["↓"], "", arrow(0, -1)],
    [["+", "−"], "Zoom", null],
    [["+", "="], "", turn(0, 0, 1 / 1.15)],
    [["−", "-"], "", turn(0, 0, 1.15)],
    [["C"], "Move the camera back", press("camera")],
    [["W"], "Edges of the faces", press("wireframe")],
    [["L"], "Lattice", press("lattice")],
    [["T"], "Light or dark", press("theme")],
    [["?"], "List the keys", press("help")],
  ];
}
