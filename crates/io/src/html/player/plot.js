// The plots of the volumes over time.

// Returns a volume as the difference from the volume at rest, in percent; NaN without a volume at rest.
function volumeChange(body, frame, kind) {
  const rest = body.volumes[3 * frame];
  return rest > 0 ? 100 * (body.volumes[3 * frame + kind] / rest - 1) : NaN;
}

const BEFORE = 1,
  AFTER = 2;

function percent(value) {
  if (Number.isNaN(value)) return "–";
  const rounded = value.toFixed(2);
  return (
    (rounded === "-0.00" ? "0.00" : value > 0 && rounded !== "0.00" ? "+" + rounded : rounded).replace("-", "−") + " %"
  );
}

// Returns the common range of the plots: of all volumes, before and after the correction.
function volumeRange(runs) {
  let low = 0,
    high = 0;
  for (const run of runs) {
    for (const body of run.bodies) {
      for (let frame = 0; frame < run.frames; frame++) {
        for (const kind of [BEFORE, AFTER]) {
          const value = volumeChange(body, frame, kind);
          if (value < low) low = value;
          if (value > high) high = value;
        }
      }
    }
  }
  const margin = Math.max((high - low) * 0.1, 0.5);
  return [low - margin, high + margin];
}

// The plot of a run, with a table of the volumes of the bodies in the shown frame.
class Plot {
  // `seek` shows a frame.
  constructor(run, range, frames, seek) {
    Object.assign(this, { run, range, frames });
    this.element = document.createElement("div");
    this.element.className = "plot";
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute(
      "aria-label",
      `Volumes of ${run.name} over time: dashed before the correction, solid after it`,
    );
    const inner = document.createElement("div");
    inner.className = "inner";
    inner.append(this.canvas, this.table());
    this.element.append(inner);
    const drag = (event) => {
      if (event.buttons !== 1) return;
      this.canvas.setPointerCapture(event.pointerId);
      const { left, right } = this.area(),
        x = event.offsetX;
      seek(Math.round(((x - left) / (right - left)) * (frames - 1)));
    };
    this.canvas.addEventListener("pointerdown", drag);
    this.canvas.addEventListener("pointermove", drag);
  }

  table() {
    const holder = document.createElement("div"),
      table = document.createElement("table");
    holder.className = "table";
    holder.tabIndex = 0;
    holder.setAttribute("role", "region");
    holder.setAttribute("aria-label", `Volumes of ${this.run.name} in the shown frame`);
    const head = table.createTHead().insertRow();
    for (const title of ["Volume", "before", "after"]) {
      const cell = document.createElement("th");
      cell.scope = "col";
      cell.textContent = title;
      head.append(cell);
    }
    const rows = table.createTBody();
    this.cells = this.run.bodies.map((body, index) => {
      const row = rows.insertRow(),
        name = document.createElement("th"),
        swatch = document.createElement("span");
      swatch.className = "swatch";
      swatch.style.background = bodyColor(index);
      name.scope = "row";
      name.append(swatch, body.name);
      row.append(name);
      return [row.insertCell(), row.insertCell()];
    });
    holder.append(table);
    return holder;
  }

  // Returns the rectangle of the curves.
  area() {
    return { left: 54, right: this.canvas.clientWidth - 14, top: 24, bottom: this.canvas.clientHeight - 20 };
  }

  // Draws the curves, and the frame that is shown.
  draw(shown) {
    const { canvas, run, frames } = this,
      context = canvas.getContext("2d"),
      ratio = devicePixelRatio || 1;
    const style = getComputedStyle(document.documentElement),
      color = (name) => style.getPropertyValue(name).trim();
    const { clientWidth: width, clientHeight: height } = canvas,
      { left, right, top, bottom } = this.area();
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const [low, high] = this.range;
    const x = (frame) => left + (right - left) * (frames > 1 ? frame / (frames - 1) : 0.5);
    const y = (value) => bottom - ((bottom - top) * (value - low)) / (high - low);
    context.font = "12px system-ui, sans-serif";
    context.lineWidth = 1;
    this.drawAxes(context, { x, y, color });
    const curve = (body, index, kind) => {
      context.beginPath();
      for (let frame = 0; frame < run.frames; frame++) context.lineTo(x(frame), y(volumeChange(body, frame, kind)));
      context.strokeStyle = bodyColor(index);
      context.setLineDash(kind === BEFORE ? [4, 3] : []);
      context.globalAlpha = kind === BEFORE ? 0.75 : 1;
      context.lineWidth = kind === BEFORE ? 1.3 : 2;
      context.stroke();
      context.setLineDash([]);
      context.globalAlpha = 1;
    };
    run.bodies.forEach((body, index) => curve(body, index, BEFORE));
    run.bodies.forEach((body, index) => curve(body, index, AFTER));
    const frame = Math.min(shown, run.frames - 1);
    context.strokeStyle = color("--ink");
    context.lineWidth = 1.2;
    context.beginPath();
    context.moveTo(x(shown), top - 4);
    context.lineTo(x(shown), bottom);
    context.stroke();
    run.bodies.forEach((body, index) => {
      for (const kind of [BEFORE, AFTER]) {
        context.beginPath();
        context.arc(x(frame), y(volumeChange(body, frame, kind)), kind === AFTER ? 3.6 : 2.6, 0, 2 * Math.PI);
        context.fillStyle = bodyColor(index);
        context.fill();
        this.cells[index][kind - 1].textContent = percent(volumeChange(body, frame, kind));
      }
    });
  }

  drawAxes(context, { x, y, color }) {
    const { left, right, top, bottom } = this.area(),
      [low, high] = this.range;
    const step = roundLength((high - low) / 3.4);
    context.fillStyle = color("--soft");
    context.strokeStyle = color("--line");
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (let tick = Math.ceil(low / step); tick * step <= high; tick++) {
      context.beginPath();
      context.moveTo(left, y(tick * step));
      context.lineTo(right, y(tick * step));
      context.stroke();
      context.fillText(
        `${(tick * step).toFixed(Math.max(0, -Math.floor(Math.log10(step))))}`.replace("-", "−"),
        left - 7,
        y(tick * step),
      );
    }
    context.textAlign = "left";
    const keys = right - left > 280 ? "   ┄ before   — after correction" : "";
    context.fillText(`Volume change in %${keys}`, left - 42, 11);
    context.textBaseline = "alphabetic";
    context.textAlign = "center";
    const seconds = ((this.frames - 1) * this.run.every) / this.run.fps;
    const interval = roundLength(seconds / Math.max((right - left) / 110, 1)) || 1;
    for (let time = 0; time <= seconds * 1.0001 && seconds > 0; time += interval) {
      const at = x((time / seconds) * (this.frames - 1));
      context.fillText(`${Number(time.toFixed(6))} s`, Math.min(at, right - 4), bottom + 15);
    }
  }
}
