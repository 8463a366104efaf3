// The playground: sliders, selectors, presets, dragging, and an address that repeats what is seen.

import data from "../../_build/playground/data.js";
import { address } from "./address.js";
import { Picture } from "./picture.js";
import { places, startPoses } from "./start.js";
import { run, Swarm } from "./swarm.js";

/** For tests and for who scripts the page, worlds by name: start poses (robots, 3), and a run as steps + 1 frames of poses. */
window.playground = {
  data,
  start: (world, robots, seed, index) => startPoses(data.worlds[world], robots, seed, index),
  run: (world, controller, poses, steps) => run(data.worlds[world], controller, poses, steps),
};

const root = document.getElementById("playground");
const SLIDERS = ["v0", "w0", "v1", "w1"];
const TRAIL_TICKS = 120;
/** Ticks shown in a second: three times the robots' own speed. */
const SPEED = 30;

if (root) start(root);

function start(root) {
  const find = (name) => root.querySelector(`[data-part="${name}"]`);
  const picture = new Picture(find("picture"));
  let state = read() ?? fromPreset(data.presets[0]);
  let swarm, trails, chosen = 0, dragging = false, ticks = 0;
  let running = !matchMedia("(prefers-reduced-motion: reduce)").matches;

  function fromPreset(preset) {
    const robots = data.worlds[preset.world].num_robots;
    return { world: preset.world, controller: [...preset.controller], robots, seed: preset.seed, index: 0 };
  }

  function sameController(a, b) {
    return a.every((value, k) => Math.abs(value - b[k]) < 1e-9);
  }

  function presetOf(state) {
    return data.presets.find((p) => p.world === state.world && sameController(p.controller, state.controller));
  }

  /** The address's state, or null where it has none that makes sense. */
  function read() {
    const given = new URLSearchParams(location.hash.slice(1)), world = data.worlds[given.get("w")];
    const controller = (given.get("c") ?? "").split(",").map(Number);
    if (!world || controller.length !== 4 || !controller.every(Number.isFinite)) return null;
    const limits = [world.linear_speed, world.angular_speed];
    const robots = Math.round(Number(given.get("n")) || world.num_robots);
    return {
      world: given.get("w"),
      controller: controller.map((value, k) => Math.max(-limits[k % 2], Math.min(limits[k % 2], value))),
      robots: Math.max(1, Math.min(places(world), robots)),
      seed: Number(given.get("s")) >>> 0,
      index: Number(given.get("i")) >>> 0,
    };
  }

  function share() {
    history.replaceState(null, "", address(state));
  }

  /** Robots at their start. */
  function restart() {
    const world = data.worlds[state.world];
    swarm = new Swarm(world, startPoses(world, state.robots, state.seed, state.index), state.controller);
    trails = swarm.poses().map(() => []);
    chosen = Math.min(chosen, state.robots - 1);
    ticks = 0;
    picture.fit(world);
    draw();
  }

  function draw() {
    picture.draw(swarm, trails, document.activeElement === picture.canvas || dragging ? chosen : -1);
    find("time").textContent = `${(ticks * swarm.world.tick).toFixed(0)} s`;
    const seeing = swarm.detections.filter(Boolean).length;
    find("seeing").textContent = `${seeing} of ${swarm.bodies.length}`;
  }

  function tick() {
    swarm.tick();
    ticks++;
    swarm.poses().forEach(([x, y], i) => {
      trails[i].push([x, y]);
      if (trails[i].length > TRAIL_TICKS) trails[i].shift();
    });
  }

  /** Write the state into the controls. */
  function show() {
    const world = data.worlds[state.world];
    find("world").value = state.world;
    find("robots").max = places(world);
    find("robots").value = state.robots;
    find("robots-value").textContent = state.robots;
    SLIDERS.forEach((name, k) => {
      const limit = k % 2 ? world.angular_speed : world.linear_speed, slider = find(name);
      slider.min = -limit;
      slider.max = limit;
      slider.value = state.controller[k];
      const text = k % 2 ? `${state.controller[k].toFixed(2)} rad/s` : `${(100 * state.controller[k]).toFixed(1)} cm/s`;
      slider.setAttribute("aria-valuetext", text);
      find(`${name}-value`).textContent = text;
    });
    const preset = presetOf(state);
    root.querySelectorAll("[data-preset]").forEach((button) => button.setAttribute("aria-pressed", data.presets[button.dataset.preset] === preset));
    find("run").textContent = running ? "Pause" : "Run";
  }

  /** Take a changed state on; `again` puts robots back to their start. */
  function change(changes, again) {
    state = { ...state, ...changes };
    const world = data.worlds[state.world], limits = [world.linear_speed, world.angular_speed];
    state.controller = state.controller.map((value, k) => Math.max(-limits[k % 2], Math.min(limits[k % 2], value)));
    state.robots = Math.min(state.robots, places(world));
    if (again) restart();
    swarm.controller = state.controller;
    show();
    share();
  }

  Object.entries(data.worlds).forEach(([name, world]) => find("world").add(new Option(name, name, false, name === state.world)));
  data.presets.forEach((preset, k) => {
    const button = document.createElement("button");
    button.type = "button";
    button.dataset.preset = k;
    button.textContent = `${preset.behaviour}, ${preset.world}`;
    button.addEventListener("click", () => change(fromPreset(preset), true));
    find("presets").append(button);
  });
  SLIDERS.forEach((name, k) =>
    find(name).addEventListener("input", (event) => change({ controller: state.controller.with(k, Number(event.target.value)) }, false)));
  find("world").addEventListener("change", (event) => change({ world: event.target.value }, true));
  find("robots").addEventListener("input", (event) => change({ robots: Number(event.target.value) }, true));
  find("restart").addEventListener("click", () => change({}, true));
  find("another").addEventListener("click", () => change({ seed: (state.seed + 1) >>> 0, index: 0 }, true));
  find("run").addEventListener("click", () => {
    running = !running;
    show();
  });
  find("share").addEventListener("click", async () => {
    share();
    try {
      await navigator.clipboard.writeText(location.href);
      find("shared").textContent = "Address copied.";
    } catch {
      find("shared").textContent = "The address bar holds the link.";
    }
  });

  /** Put robot i to (x, y), kept on the floor. */
  function lift(i, x, y) {
    const [width, height] = swarm.world.size, radius = swarm.world.contact_radius;
    swarm.place(i, Math.max(radius, Math.min(width - radius, x)), Math.max(radius, Math.min(height - radius, y)));
    trails[i] = [];
    draw();
  }

  const canvas = picture.canvas;
  canvas.addEventListener("pointerdown", (event) => {
    const [x, y] = picture.point(event);
    const distances = swarm.poses().map((pose) => Math.hypot(pose[0] - x, pose[1] - y));
    const nearest = distances.indexOf(Math.min(...distances));
    if (distances[nearest] > 1.5 * swarm.world.contact_radius) return;
    chosen = nearest;
    dragging = true;
    swarm.held = nearest;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => dragging && lift(chosen, ...picture.point(event)));
  ["pointerup", "pointercancel"].forEach((name) => canvas.addEventListener(name, () => {
    dragging = false;
    swarm.held = -1;
  }));
  canvas.addEventListener("keydown", (event) => {
    const step = 0.02, [x, y] = swarm.poses()[chosen];
    const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    if (moves[event.key]) lift(chosen, x + moves[event.key][0], y + moves[event.key][1]);
    else if (event.key === "n") chosen = (chosen + 1) % swarm.bodies.length;
    else if (event.key === " ") find("run").click();
    else return;
    event.preventDefault();
    draw();
  });
  addEventListener("resize", () => {
    picture.fit(swarm.world);
    draw();
  });
  addEventListener("hashchange", () => change(read() ?? state, true));

  restart();
  show();
  let last = performance.now(), owed = 0;
  requestAnimationFrame(function frame(now) {
    if (running) {
      owed = Math.min(owed + ((now - last) / 1000) * SPEED, 4);
      for (; owed >= 1; owed--) tick();
    }
    last = now;
    draw(); // also while paused: the theme may have changed
    requestAnimationFrame(frame);
  });
}
