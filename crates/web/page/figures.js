// The figures beside the picture: means over half a second.

const PERIOD = 500;

// Least share of real time that is not called slow motion.
const REAL_TIME = 0.95;

// Returns a relative error: in percent, or as a power of ten if it is small.
export function errorText(error) {
  if (!Number.isFinite(error)) return "–";
  if (Math.abs(error) >= 5e-5) return `${error > 0 ? "+" : "−"}${(100 * Math.abs(error)).toFixed(2)} %`;
  if (Math.abs(error) < 1e-15) return "0";
  const [digits, power] = error.toExponential(1).split("e");
  return `${digits.replace("-", "−")} · 10${[...power].map((digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)]).join("")}`;
}

function milliseconds(sum, count) {
  return count > 0 ? `${(sum / count).toFixed(1)} ms` : "–";
}

export class Figures {
  constructor(at) {
    this.at = at;
    this.clear();
  }

  clear() {
    this.began = performance.now();
    Object.assign(this, { evaluated: 0, stepTime: 0, surfaceTime: 0, drawn: 0, drawTime: 0, pictures: 0 });
    Object.assign(this, { frames: 0, elapsed: 0 });
  }

  // Adds an answer of the simulation, `elapsed` seconds after the one before.
  addFrame(answer, elapsed) {
    this.frames += answer.frames;
    this.elapsed += elapsed;
    if (!answer.buffer) return;
    this.evaluated++;
    this.stepTime += answer.stepTime;
    this.surfaceTime += answer.surfaceTime;
  }

  addDrawing(time) {
    this.drawn++;
    this.drawTime += time;
  }

  // Shows the means and begins new ones, if the period is over. Called for each picture of the screen.
  update({ isPaused, isAtRest, isReduced, frame }) {
    this.pictures++;
    const now = performance.now(),
      passed = now - this.began;
    if (passed < PERIOD) return;
    const { at } = this;
    at("step-time").textContent = milliseconds(this.stepTime, this.evaluated);
    at("surface-time").textContent = milliseconds(this.surfaceTime, this.evaluated);
    at("draw-time").textContent = milliseconds(this.drawTime, this.drawn);
    at("rate").textContent = ((1000 * this.pictures) / passed).toFixed(0);
    const speed = this.elapsed > 0 ? (this.frames * frame) / this.elapsed : 1;
    this.speed = speed;
    let text = "In real time.";
    if (isPaused) text = "Paused.";
    else if (isAtRest) text = "At rest: nothing is computed until something moves the body.";
    else if (speed < REAL_TIME) {
      const time = (this.stepTime + this.surfaceTime) / (this.evaluated || 1);
      text = `Slow motion: ${(100 * speed).toFixed(0)} % of real time.`;
      if (time > 1000 * frame) text += " Fewer lattice vertices make it faster.";
    }
    if (isReduced) text += " This browser draws slowly, so that less detail is drawn.";
    // Screen readers announce every change of the text.
    if (at("pace").textContent !== text) at("pace").textContent = text;
    this.clear();
  }

  // Shows the volume errors and the number of steps of an answer.
  showVolume({ volumeError, volumeErrorBefore, steps }) {
    this.at("volume-error").textContent = errorText(volumeError);
    this.at("volume-before").textContent = errorText(volumeErrorBefore);
    this.at("steps").textContent = String(steps);
  }

  // Shows the sizes of a new body.
  showBody({ surface, lattice, isClosed }) {
    this.at("lattice-vertices").textContent = lattice.toLocaleString("en");
    this.at("mesh-vertices").textContent = surface.vertices.toLocaleString("en");
    this.at("volume-name").textContent = isClosed ? "Volume error" : "Volume error of the cells: the mesh is open";
    this.clear();
  }
}
