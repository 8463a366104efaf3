// The archive of a discovery run: what docs/site/atlas.py wrote, unpacked, and what can be said of each row.

import { address } from "./address.js";

/** Typed array of base64 little-endian numbers; every browser runs on little-endian machines. */
function unpack(text, Type) {
  return new Type(Uint8Array.from(atob(text), (character) => character.charCodeAt(0)).buffer);
}

export class Archive {
  constructor(data) {
    this.run = data.run;
    this.labels = data.labels;
    this.seeds = data.seeds;
    this.medoids = data.medoids;
    this.label = unpack(data.label, Uint8Array);
    this.generations = unpack(data.generations, Uint16Array);
    this.indices = unpack(data.indices, Uint16Array);
    this.controllers = unpack(data.controllers, Float64Array);
    this.places = Float64Array.from(unpack(data.places, Uint16Array), (value) => value / 65535);
  }

  get size() {
    return this.label.length;
  }

  /** x to the right and y upwards on the map, each from 0 to 1. */
  place(row) {
    return [this.places[2 * row], this.places[2 * row + 1]];
  }

  /** v0, omega0, v1, omega1 in m/s and rad/s, every bit. */
  controller(row) {
    return [...this.controllers.slice(4 * row, 4 * row + 4)];
  }

  /** Behaviour by rules. */
  name(row) {
    return this.labels[this.label[row]];
  }

  /** Seed of the rollout that the row comes from, and the row's world in it. */
  start(row) {
    return { seed: this.seeds[this.generations[row]], index: this.indices[row] };
  }

  /** A shell command that repeats the row's run to the bit, names it and films it. */
  command(row) {
    const { world, engine, steps } = this.run, { seed, index } = this.start(row);
    return `python -c "
import swarm_envs
controller = [${this.controller(row).join(", ")}]
runs = swarm_envs.rollouts('${world}', [controller] * ${index + 1}, seed=${seed}, steps=${steps}, engine='${engine}')[${index}:]
print(swarm_envs.behaviours.label(runs))
swarm_envs.rendering.save_video(runs, 'behaviour.gif')
"`;
  }

  /** Where the playground repeats the row's run. */
  link(row, robots) {
    return "index.html" + address({ world: this.run.world, controller: this.controller(row), robots, ...this.start(row) });
  }
}
