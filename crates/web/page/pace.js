// How many frames of the simulation a picture takes: as many as have passed at 60 a second, but never so many that the
// next picture would need still more.

// Seconds between two frames of the simulation.
export const FRAME = 1 / 60;

// Most frames between two pictures. Longer pauses are cut to this.
const MOST = 8;

export class Pace {
  constructor() {
    this.left = 0;
    // Milliseconds that a frame takes, as a moving mean.
    this.cost = 0;
  }

  // Returns the number of frames for a picture `elapsed` seconds after the one before.
  frames(elapsed) {
    this.left = Math.min(this.left + elapsed, MOST * FRAME);
    // A quarter of a frame of tolerance, so that a screen of 60 Hz gets one frame for each picture.
    let frames = Math.floor(this.left / FRAME + 0.25);
    this.left -= frames * FRAME;
    // A simulation that is slower than real time shows each of its frames, and time that is not simulated is dropped.
    if (this.cost > 1000 * FRAME && frames > 1) {
      frames = 1;
      this.left = 0;
    }
    return frames;
  }

  // Takes the time into account that some frames took.
  measure(frames, milliseconds) {
    if (frames > 0) this.cost += 0.2 * (milliseconds / frames - this.cost);
  }
}
