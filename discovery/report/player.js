"use strict";
(() => {
  const { Rollout, bytes, int16, float32, colours, readColours } = Rollouts;
  const data = JSON.parse(document.getElementById("data").textContent);
  const scene = data.scene;
  const duration = (scene.frames - 1) * scene.interval;
  const restAtEnd = 0.8; // seconds that the last frame stays before the loop starts again

  const rollouts = [...document.querySelectorAll("canvas.rollout")].map((canvas) => new Rollout(canvas, data.rollouts[canvas.dataset.index], scene));
  const play = document.getElementById("play"), speed = document.getElementById("speed"), clock = document.getElementById("clock");
  // Those who ask for less motion see the end of each run, trail and all, until they press play.
  let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches, last = null;
  if (!playing) rollouts.forEach((rollout) => { rollout.time = duration; });

  const showState = () => {
    play.textContent = playing ? "Pause all" : "Play all";
    play.setAttribute("aria-pressed", String(playing));
  };
  const drawAll = () => rollouts.forEach((rollout) => rollout.draw());
  const tick = (now) => {
    const passed = last === null ? 0 : Math.min((now - last) / 1000, 0.1) * Number(speed.value);
    last = now;
    for (const rollout of rollouts) {
      if (!rollout.playing) continue;
      rollout.time += passed;
      if (rollout.time > duration + restAtEnd * Number(speed.value)) rollout.time = 0;
      if (rollout.visible) rollout.draw();
    }
    clock.textContent = `${Math.min(rollouts[0].time, duration).toFixed(0)} s of ${duration.toFixed(0)} s`;
    if (playing) requestAnimationFrame(tick);
  };
  const start = () => { last = null; if (playing) requestAnimationFrame(tick); showState(); };
  play.addEventListener("click", () => {
    playing = !playing;
    if (playing) rollouts.forEach((rollout) => { rollout.playing = true; if (rollout.time >= duration) rollout.time = 0; });
    start();
  });
  document.getElementById("restart").addEventListener("click", () => {
    rollouts.forEach((rollout) => { rollout.time = 0; rollout.playing = true; });
    if (!playing) { playing = true; start(); }
  });
  for (const rollout of rollouts) rollout.canvas.addEventListener("click", () => { rollout.playing = !rollout.playing; });
  if ("IntersectionObserver" in window) {
    const seen = new IntersectionObserver((entries) => entries.forEach((entry) => {
      const rollout = rollouts[entry.target.dataset.index];
      rollout.visible = entry.isIntersecting;
      if (rollout.visible) rollout.draw();
    }), { rootMargin: "100px" });
    rollouts.forEach((rollout) => seen.observe(rollout.canvas));
  }

  // ---- map -----------------------------------------------------------------------------------------------------
  const map = document.getElementById("map"), tip = document.getElementById("tip");
  const places = int16(data.map.places), labels = bytes(data.map.labels), controllers = float32(data.map.controllers), generations = int16(data.map.generations);
  let spots = [], chosen = -1, density = 1;
  const fitMap = () => {
    density = Math.min(window.devicePixelRatio || 1, 2);
    map.width = Math.round(map.clientWidth * density);
    map.height = Math.round(map.clientHeight * density);
    const edge = 22 * density;
    spots = Array.from({ length: data.map.count }, (_, i) => [
      edge + (places[2 * i] / 32000) * (map.width - 2 * edge), map.height - edge - (places[2 * i + 1] / 32000) * (map.height - 2 * edge)]);
  };
  const drawMap = () => {
    const context = map.getContext("2d");
    context.clearRect(0, 0, map.width, map.height);
    context.globalAlpha = 0.72;
    spots.forEach(([x, y], i) => {
      context.fillStyle = colours.of(data.map.names[labels[i]]);
      context.beginPath();
      context.arc(x, y, 3.1 * density, 0, 7);
      context.fill();
    });
    context.globalAlpha = 1;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.font = `700 ${11 * density}px system-ui, sans-serif`;
    data.map.medoids.forEach((row, number) => {
      const [x, y] = spots[row];
      context.beginPath();
      context.arc(x, y, 10 * density, 0, 7);
      context.fillStyle = colours.card;
      context.fill();
      context.lineWidth = 3 * density;
      context.strokeStyle = colours.of(data.map.names[labels[row]]);
      context.stroke();
      context.fillStyle = colours.ink;
      context.fillText(String(number + 1), x, y + 0.5 * density);
    });
    if (chosen >= 0) {
      context.beginPath();
      context.arc(...spots[chosen], 6 * density, 0, 7);
      context.lineWidth = 2 * density;
      context.strokeStyle = colours.ink;
      context.stroke();
    }
  };
  const signed = (value, digits) => (value < 0 ? "−" : "+") + Math.abs(value).toFixed(digits);
  const pair = (i, k) => `v ${signed(100 * controllers[4 * i + k], 1)} cm/s, ω ${signed(controllers[4 * i + k + 1], 2)} rad/s`;
  const point = (event) => {
    const box = map.getBoundingClientRect(), mx = (event.clientX - box.left) * density, my = (event.clientY - box.top) * density;
    let best = -1, nearest = (18 * density) ** 2;
    const look = (i, reach) => { const d = (spots[i][0] - mx) ** 2 + (spots[i][1] - my) ** 2; if (d < nearest && d < reach) { nearest = d; best = i; } };
    data.map.medoids.forEach((i) => look(i, (11 * density) ** 2));
    if (best < 0) spots.forEach((_, i) => look(i, Infinity));
    show(best, box);
  };
  const show = (i, box) => {
    chosen = i;
    drawMap();
    tip.hidden = i < 0;
    if (i < 0) return;
    const medoid = data.map.medoids.indexOf(i), lines = [
      data.map.names[labels[i]] + (medoid >= 0 ? `, behaviour ${medoid + 1}` : ""), `sees nothing: ${pair(i, 0)}`, `sees a robot: ${pair(i, 2)}`, `generation ${generations[i]}`];
    tip.replaceChildren(...lines.map((text, k) => { const line = document.createElement(k ? "div" : "b"); line.textContent = text; return line; }));
    const x = spots[i][0] / density, y = spots[i][1] / density;
    tip.style.left = Math.max(0, Math.min(x + 14, box.width - tip.offsetWidth)) + "px";
    tip.style.top = (y > box.height / 2 ? y - tip.offsetHeight - 14 : y + 14) + "px";
  };
  map.addEventListener("pointermove", point);
  map.addEventListener("pointerdown", point);
  map.addEventListener("pointerleave", () => show(-1));
  map.addEventListener("click", () => {
    const medoid = data.map.medoids.indexOf(chosen);
    if (medoid >= 0) location.hash = `behaviour-${medoid + 1}`;
  });
  // With the keyboard: arrow keys go from one numbered behaviour to the next.
  map.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const count = data.map.medoids.length, now = data.map.medoids.indexOf(chosen);
    show(data.map.medoids[(now + step + count + (now < 0 && step < 0 ? 1 : 0)) % count], map.getBoundingClientRect());
  });
  map.addEventListener("blur", () => show(-1));

  const layOut = () => { rollouts.forEach((rollout) => rollout.fit()); fitMap(); drawAll(); drawMap(); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); layOut(); });
  let pending = 0;
  window.addEventListener("resize", () => { clearTimeout(pending); pending = setTimeout(layOut, 120); });
  layOut();
  start();
})();
