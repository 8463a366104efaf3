"use strict";
// Maps of the test set, one per representation; what is pointed at on one is marked on all and played beside them.
(() => {
  const { Rollout, bytes, int16, colours, readColours } = Rollouts;
  const data = JSON.parse(document.getElementById("data").textContent);
  const find = (id) => document.getElementById(id);
  const labels = bytes(data.labels), count = labels.length;
  const shown = data.names.map(() => true);
  // One shape per behaviour, within a circle of radius 1 about the origin: colour is not all that tells them apart.
  const outlines = {
    "aggregation": null,
    "cyclic pursuit": [[-0.8, -0.8], [0.8, -0.8], [0.8, 0.8], [-0.8, 0.8]],
    "dispersal": [[0, -1], [0.95, 0.75], [-0.95, 0.75]],
    "milling": [[0, -1.1], [1.1, 0], [0, 1.1], [-1.1, 0]],
    "wall following": [[0, 1], [0.95, -0.75], [-0.95, -0.75]],
    "random": [[-1, -0.6], [-0.6, -1], [0, -0.4], [0.6, -1], [1, -0.6], [0.4, 0], [1, 0.6], [0.6, 1], [0, 0.4], [-0.6, 1], [-1, 0.6], [-0.4, 0]],
  };
  const trace = (context, label, x, y, size) => {
    const outline = outlines[data.names[label]];
    context.beginPath();
    if (!outline) { context.arc(x, y, size * 0.9, 0, 7); return; }
    outline.forEach(([px, py], i) => (i ? context.lineTo(x + size * px, y + size * py) : context.moveTo(x + size * px, y + size * py)));
    context.closePath();
  };

  let chosen = 0, playing = !matchMedia("(prefers-reduced-motion: reduce)").matches, last = null, rollout = null;
  const maps = [...document.querySelectorAll("[data-map]")].map((canvas) => ({ canvas, places: int16(data.maps[canvas.dataset.map].places), spots: [] }));

  const fit = (map) => {
    const density = map.density = Math.min(window.devicePixelRatio || 1, 2), edge = 12 * density;
    const side = map.canvas.width = map.canvas.height = Math.max(1, Math.round(map.canvas.clientWidth * density));
    map.spots = Array.from({ length: count }, (_, i) => [
      edge + (map.places[2 * i] / 32000) * (side - 2 * edge), side - edge - (map.places[2 * i + 1] / 32000) * (side - 2 * edge)]);
  };
  const draw = (map) => {
    const context = map.canvas.getContext("2d");
    context.clearRect(0, 0, map.canvas.width, map.canvas.height);
    context.globalAlpha = 0.85;
    map.spots.forEach(([x, y], i) => {
      if (!shown[labels[i]]) return;
      context.fillStyle = colours.of(data.names[labels[i]]);
      trace(context, labels[i], x, y, 3.6 * map.density);
      context.fill();
    });
    context.globalAlpha = 1;
    const [x, y] = map.spots[chosen];
    for (const [width, colour] of [[5, colours.card], [2.5, colours.ink]]) {
      context.beginPath();
      context.arc(x, y, 8 * map.density, 0, 7);
      context.lineWidth = width * map.density;
      context.strokeStyle = colour;
      context.stroke();
    }
    context.fillStyle = colours.of(data.names[labels[chosen]]);
    trace(context, labels[chosen], x, y, 4.5 * map.density);
    context.fill();
  };
  const choose = (row) => {
    if (row < 0 || (row === chosen && rollout)) return;
    chosen = row;
    rollout = new Rollout(find("rollout"), data.rollouts[row], data.scene);
    rollout.fit();
    if (!playing) rollout.time = rollout.duration; // its end, trail and all
    rollout.draw();
    find("shown").textContent = `Rollout ${row + 1} of ${count}: ${data.names[labels[row]]}`;
    maps.forEach(draw);
  };

  const nearest = (map, event) => {
    const box = map.canvas.getBoundingClientRect(), mx = (event.clientX - box.left) * map.density, my = (event.clientY - box.top) * map.density;
    let best = -1, least = (18 * map.density) ** 2;
    map.spots.forEach(([x, y], i) => {
      const distance = (x - mx) ** 2 + (y - my) ** 2;
      if (shown[labels[i]] && distance < least) { least = distance; best = i; }
    });
    return best;
  };
  // The nearest within a quarter of the circle about the key's direction; farther sideways counts as farther.
  const next = (map, dx, dy) => {
    const [x, y] = map.spots[chosen];
    let best = -1, least = Infinity;
    map.spots.forEach(([px, py], i) => {
      const along = (px - x) * dx + (py - y) * dy, across = Math.abs((px - x) * dy) + Math.abs((py - y) * dx);
      if (i === chosen || !shown[labels[i]] || along <= 0 || across > along) return;
      if (along + 2 * across < least) { least = along + 2 * across; best = i; }
    });
    return best;
  };
  const keys = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  for (const map of maps) {
    map.canvas.addEventListener("pointermove", (event) => choose(nearest(map, event)));
    map.canvas.addEventListener("pointerdown", (event) => choose(nearest(map, event)));
    map.canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
      event.preventDefault();
      choose(next(map, ...keys[event.key]));
    });
  }

  const paintLegend = () => {
    for (const button of find("legend").querySelectorAll("button")) {
      const name = data.names[button.dataset.label], outline = outlines[name], path = button.querySelector("path");
      path.setAttribute("d", outline ? "M" + outline.map(([x, y]) => `${7 * x} ${7 * y}`).join("L") + "Z" : "M-6 0a6 6 0 1 0 12 0a6 6 0 1 0-12 0");
      path.setAttribute("fill", colours.of(name));
    }
  };
  for (const button of find("legend").querySelectorAll("button")) {
    button.addEventListener("click", () => {
      const label = button.dataset.label;
      shown[label] = !shown[label];
      button.setAttribute("aria-pressed", String(shown[label]));
      maps.forEach(draw);
    });
  }

  const tick = (now) => {
    const passed = last === null ? 0 : Math.min((now - last) / 1000, 0.1) * Number(find("speed").value);
    last = now;
    rollout.time += passed;
    if (rollout.time > rollout.duration + 0.8 * Number(find("speed").value)) rollout.time = 0;
    rollout.draw();
    if (playing) requestAnimationFrame(tick);
  };
  const start = () => {
    find("play").textContent = playing ? "Pause" : "Play";
    find("play").setAttribute("aria-pressed", String(playing));
    last = null;
    if (playing) requestAnimationFrame(tick);
  };
  find("play").addEventListener("click", () => { playing = !playing; start(); });
  const layOut = () => {
    maps.forEach((map) => { fit(map); draw(map); });
    if (rollout) { rollout.fit(); rollout.draw(); }
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); paintLegend(); layOut(); });
  let pending = 0;
  addEventListener("resize", () => { clearTimeout(pending); pending = setTimeout(layOut, 120); });

  paintLegend();
  layOut();
  choose(0);
  start();
  /** For tests and for who scripts the page. */
  window.maps = { spot: (map, row) => maps[map].spots[row].map((value) => value / maps[map].density), chosen: () => chosen, time: () => rollout.time };
})();
