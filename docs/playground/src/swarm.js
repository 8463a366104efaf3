// A swarm in a world: planck finds and solves contacts, the arcs are exact. Positions in m, headings in rad, counter-clockwise, y up.

import { Circle, Edge, Settings, World } from "planck";
import { meanVelocity } from "./arc.js";
import { detect } from "./sensing.js";

// planck's defaults are for bodies of a metre: these are for robots of a few centimetres, in metres
Settings.linearSlop = 2e-4;
Settings.velocityThreshold = 0;
Settings.aabbExtension = 0.02;
const VELOCITY_ITERATIONS = 10;
const POSITION_ITERATIONS = 6;
/** A friction of nothing; the geometric mean of a robot's and a wall's has to be the wall's. */
const LITTLE = 1e-9;

export class Swarm {
  /**
   * @param {object} world one of worlds.json
   * @param {number[][]} poses x, y, heading of every robot
   * @param {number[]} controller v0, omega0 without a robot in view; v1, omega1 with one
   */
  constructor(world, poses, controller) {
    this.world = world;
    this.controller = controller;
    this.held = -1;
    this.space = new World({ gravity: { x: 0, y: 0 }, allowSleep: false, continuousPhysics: false });
    this.addWalls();
    this.bodies = poses.map((pose) => this.addRobot(pose));
    this.detections = detect(this.poses(), world);
  }

  addWalls() {
    const { outline, robot_friction: robot, wall_friction: wall } = this.world;
    const friction = (wall * wall) / Math.max(robot, LITTLE);
    const ground = this.space.createBody();
    outline.forEach((corner, k) => {
      const next = outline[(k + 1) % outline.length];
      ground.createFixture({ shape: new Edge({ x: corner[0], y: corner[1] }, { x: next[0], y: next[1] }), friction });
    });
  }

  addRobot(pose) {
    const { contact_radius: radius, mass, inertia_ratio: ratio, robot_friction: robot } = this.world;
    const body = this.space.createBody({ type: "dynamic", position: { x: pose[0], y: pose[1] }, angle: pose[2] });
    body.createFixture({ shape: new Circle(radius), density: 1, friction: Math.max(robot, LITTLE), restitution: 0 });
    body.setMassData({ mass, center: { x: 0, y: 0 }, I: ratio * mass * radius * radius });
    return body;
  }

  /** x, y, heading of every robot. */
  poses() {
    return this.bodies.map((body) => [body.getPosition().x, body.getPosition().y, body.getAngle()]);
  }

  /** Put robot i somewhere, as a visitor who lifts it does. */
  place(i, x, y) {
    this.bodies[i].setTransform({ x, y }, this.bodies[i].getAngle());
  }

  /** Drive one tick: read the sensors, give the commands, move with contact. */
  tick() {
    const { tick, substeps } = this.world;
    this.detections = detect(this.poses(), this.world);
    const duration = tick / substeps;
    for (let k = 0; k < substeps; k++) {
      this.bodies.forEach((body, i) => {
        const at = this.detections[i] ? 2 : 0;
        const [v, omega] = i === this.held ? [0, 0] : [this.controller[at], this.controller[at + 1]];
        body.setLinearVelocity(meanVelocity(body.getAngle(), v, omega, duration));
        body.setAngularVelocity(omega);
      });
      this.space.step(duration, VELOCITY_ITERATIONS, POSITION_ITERATIONS);
    }
  }
}

/** Run a controller from given poses; return steps + 1 frames of poses (robots, 3). */
export function run(world, controller, poses, steps) {
  const swarm = new Swarm(world, poses, controller);
  const frames = [swarm.poses()];
  for (let k = 0; k < steps; k++) {
    swarm.tick();
    frames.push(swarm.poses());
  }
  return frames;
}
