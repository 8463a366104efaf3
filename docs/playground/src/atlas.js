// The behaviour atlas: a map of a run's archive; pointing at a point plays it, choosing one tells how to repeat it.

import atlas from "../../site/atlas.json";
import data from "../../_build/playground/data.js";
import { Archive } from "./archive.js";
import { ArchiveMap } from "./map.js";
import { Preview } from "./preview.js";
import { startPoses } from "./start.js";
import { run } from "./swarm.js";

const root = document.getElementById("atlas");
if (root) start(root, new Archive(atlas));

function start(root, archive) {
  const find = (name) => root.querySelector(`[data-part="${name}"]`);
  const world = data.worlds[archive.run.world], robots = world.num_robots;
  const map = new ArchiveMap(find("map"), archive), preview = new Preview(find("picture"), world, archive.run.steps);
  const canvas = map.canvas;
  let pointed = -1, chosen = -1;

  /** For tests and for who scripts the page: the map, and poses of a row's run here, steps + 1 frames of (robots, 3). */
  window.atlas = { map, run: (row) => run(world, archive.controller(row), poses(row), archive.run.steps) };

  function poses(row) {
    const { seed, index } = archive.start(row);
    return startPoses(world, robots, seed, index);
  }

  function draw() {
    map.draw(pointed, chosen);
    canvas.style.touchAction = map.zoom > 1 ? "none" : "pan-x pan-y"; // of the whole map a finger moves the page
  }

  /** Play what is pointed at, else what is chosen. */
  function play(row) {
    preview.play(archive.controller(row), poses(row));
    const medoid = archive.medoids.findIndex((each) => each.row === row);
    find("shown").textContent = `${archive.name(row)}${medoid < 0 ? "" : `, medoid ${medoid + 1}`}${row === chosen ? "" : " (click to keep)"}`;
  }

  function point(row) {
    if (row === pointed) return;
    pointed = row;
    play(row < 0 ? chosen : row);
    draw();
  }

  function choose(row) {
    if (row < 0) return;
    chosen = row;
    pointed = -1;
    map.reveal(row);
    play(row);
    archive.controller(row).forEach((value, k) => {
      find(`gene-${k}`).textContent = k % 2 ? `${value.toFixed(3)} rad/s` : `${(100 * value).toFixed(2)} cm/s`;
    });
    find("command").textContent = archive.command(row);
    find("open").href = archive.link(row, robots);
    find("copied").textContent = "";
    root.querySelectorAll("[data-row]").forEach((button) => button.setAttribute("aria-pressed", Number(button.dataset.row) === row));
    draw();
  }

  function resize() {
    map.fit();
    preview.fit();
    draw();
  }

  function button(text, label, behaviour) {
    const made = document.createElement("button"), dot = document.createElement("i");
    made.type = "button";
    dot.className = "dot";
    dot.style.setProperty("--dot", `var(--swarm-label-${behaviour.replace(" ", "-")})`);
    made.append(dot, text);
    if (label) made.setAttribute("aria-label", label);
    return made;
  }

  archive.labels.forEach((name, label) => {
    const count = archive.label.filter((each) => each === label).length, made = button(`${name} ${count}`, "", name);
    made.setAttribute("aria-pressed", "true");
    made.addEventListener("click", () => {
      map.shown[label] = !map.shown[label];
      made.setAttribute("aria-pressed", map.shown[label]);
      draw();
    });
    find("legend").append(made);
  });
  archive.medoids.forEach(({ row, share }, k) => {
    const percent = `${Math.round(100 * share)} %`, name = archive.name(row);
    const made = button(`${k + 1} ${name}, ${percent}`, "", name);
    made.dataset.row = row;
    made.addEventListener("click", () => choose(row));
    find("medoids").append(made);
  });

  const fingers = new Map();
  let moved = 0;
  canvas.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, map.pixel(event));
    moved = 0;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId), now = map.pixel(event);
    if (!before) {
      point(map.nearest(now));
      return;
    }
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1], distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
    if (other) map.zoomBy(distance(now, other) / Math.max(1, distance(before, other)), other);
    else map.moveBy(now[0] - before[0], now[1] - before[1]);
    moved += distance(before, now);
    fingers.set(event.pointerId, now);
    draw();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (moved < 5 * map.density) choose(map.nearest(map.pixel(event)));
    fingers.delete(event.pointerId);
  });
  canvas.addEventListener("pointercancel", (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("pointerleave", () => point(-1));
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return; // until the map is clicked the wheel scrolls the page
    event.preventDefault();
    map.zoomBy(Math.exp(-event.deltaY / 300), map.pixel(event));
    draw();
  }, { passive: false });
  const keys = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (keys[event.key]) choose(map.next(chosen, keys[event.key]));
    else if (event.key === "+" || event.key === "=") zoom(1.5);
    else if (event.key === "-") zoom(1 / 1.5);
    else if (event.key === "0") whole();
    else return;
    event.preventDefault();
  });

  function zoom(factor) {
    map.zoomBy(factor, map.at(archive.place(chosen)));
    draw();
  }
  function whole() {
    map.whole();
    draw();
  }
  find("nearer").addEventListener("click", () => zoom(1.5));
  find("farther").addEventListener("click", () => zoom(1 / 1.5));
  find("whole").addEventListener("click", whole);
  find("copy").addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(find("command").textContent);
      find("copied").textContent = "Copied.";
    } catch {
      find("copied").textContent = "Select the text to copy it.";
    }
  });
  addEventListener("resize", resize);
  new MutationObserver(draw).observe(document.body, { attributes: true, attributeFilter: ["data-theme"] });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);

  map.fit();
  choose(archive.medoids[0].row);
}
