// The time line: the shown frame, and whether and how fast it advances.
class Clock {
  // `frames` is the number of frames, `rate` their number per second. `changed` is called for each new frame.
  constructor(frames, rate, changed) {
    Object.assign(this, { frames, rate, changed, frame: 0, speed: 1, isPlaying: false });
    this.phase = 0;
    this.before = 0;
  }

  // Shows a frame, at the same phase of the time line.
  seek(frame) {
    this.frame = Math.min(Math.max(frame, 0), this.frames - 1);
    this.phase = this.frame;
    this.changed();
  }

  setPlaying(isPlaying) {
    this.isPlaying = isPlaying && this.frames > 1;
    this.before = performance.now();
    this.changed();
  }

  // Advances to the time of a screen refresh, in milliseconds. The last frame is shown for half a second.
  advance(now) {
    if (!this.isPlaying) return;
    const pause = 0.5 * this.rate * this.speed;
    this.phase += (Math.max(now - this.before, 0) / 1000) * this.rate * this.speed;
    this.before = now;
    if (this.phase >= this.frames + pause) this.phase = 0;
    const frame = Math.min(Math.floor(this.phase), this.frames - 1);
    if (frame !== this.frame) {
      this.frame = frame;
      this.changed();
    }
  }
}
