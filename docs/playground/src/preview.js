// A behaviour that plays by itself in a small picture, again and again.

import { Picture } from "./picture.js";
import { Swarm } from "./swarm.js";

const TRAIL_TICKS = 120;
/** Ticks shown in a second: eight times the robots' own speed. */
const SPEED = 80;
/** Seconds that the last picture stays. */
const REST = 1;

export class Preview {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {object} world one of data.js
   * @param {number} steps ticks of a run
   */
  constructor(canvas, world, steps) {
    this.picture = new Picture(canvas);
    this.world = world;
    this.steps = steps;
    this.last = performance.now();
    this.still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.frame = this.frame.bind(this);
    requestAnimationFrame(this.frame);
  }

  /** Play a controller from poses; its last picture alone for who prefers less motion. */
  play(controller, poses) {
    this.given = [controller, poses];
    this.swarm = new Swarm(this.world, poses, controller);
    this.trails = poses.map(() => []);
    this.ticks = this.owed = 0;
    this.fit();
    if (this.still) this.advance(this.steps);
  }

  fit() {
    this.picture.fit(this.world);
  }

  advance(ticks) {
    for (; ticks >= 1 && this.ticks < this.steps; ticks--, this.ticks++) {
      this.swarm.tick();
      this.swarm.poses().forEach(([x, y], i) => {
        this.trails[i].push([x, y]);
        if (this.trails[i].length > TRAIL_TICKS) this.trails[i].shift();
      });
    }
    return ticks;
  }

  frame(now) {
    const passed = Math.min((now - this.last) / 1000, 0.1) * SPEED;
    this.last = now;
    requestAnimationFrame(this.frame);
    if (!this.swarm) return;
    if (!this.still) {
      this.owed = this.advance(this.owed + passed);
      if (this.owed > REST * SPEED) this.play(...this.given);
    }
    this.picture.draw(this.swarm, this.trails, -1);
  }
}
