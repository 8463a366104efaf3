// Plays each replay: three canvases drawn from one time, moved by a slider or a button.
for (const figure of document.querySelectorAll(".replay")) {
  const run = JSON.parse(figure.querySelector("script").textContent);
  const slider = figure.querySelector("input"), button = figure.querySelector("button"), clock = figure.querySelector("output");
  const panels = [...figure.querySelectorAll("canvas")].map((canvas) => ({ canvas, path: run[canvas.dataset.path] }));
  let begun = null;

  function draw() {
    const frame = Number(slider.value);
    clock.textContent = `${(frame * run.step).toFixed(1)} s`;
    for (const { canvas, path } of panels) {
      const side = Math.round(canvas.clientWidth * devicePixelRatio) || 300;
      if (canvas.width !== side) canvas.width = canvas.height = side;
      const pen = canvas.getContext("2d"), scale = side / run.side;
      const colour = getComputedStyle(canvas).color;
      const x = (v) => (v - run.left) * scale, y = (v) => side - (v - run.bottom) * scale;
      pen.clearRect(0, 0, side, side);
      pen.strokeStyle = pen.fillStyle = colour;
      if (run.outline) {
        pen.lineWidth = side / 200;
        pen.beginPath();
        for (const [a, b] of run.outline) pen.lineTo(x(a), y(b));
        pen.closePath();
        pen.stroke();
      }
      for (const robot of path) {
        pen.lineWidth = side / 180;
        pen.globalAlpha = 0.5;
        pen.beginPath();
        for (let k = 0; k <= frame; k++) if (robot[k]) pen.lineTo(x(robot[k][0]), y(robot[k][1]));
        pen.stroke();
        pen.globalAlpha = 1;
        const now = robot[frame];
        if (!now) continue;
        const r = Math.max(run.radius * scale, side / 60);
        // a world that is far off drives a robot out of the picture: its path shows where
        if (Math.min(x(now[0]), side - x(now[0]), y(now[1]), side - y(now[1])) < r) continue;
        pen.beginPath();
        pen.arc(x(now[0]), y(now[1]), r, 0, 2 * Math.PI);
        pen.moveTo(x(now[0]), y(now[1]));
        pen.lineTo(x(now[0]) + 1.6 * r * Math.cos(now[2]), y(now[1]) - 1.6 * r * Math.sin(now[2]));
        pen.stroke();
      }
    }
  }

  function tick(time) {
    if (begun === null) return;
    slider.value = Math.min(Number(slider.max), Math.floor((time - begun) / 1000 / run.step));
    draw();
    if (Number(slider.value) < Number(slider.max)) requestAnimationFrame(tick);
    else stop();
  }

  function stop() {
    begun = null;
    button.textContent = "Play";
  }

  button.addEventListener("click", () => {
    if (begun !== null) return stop();
    const from = Number(slider.value) < Number(slider.max) ? Number(slider.value) : 0;
    begun = performance.now() - from * run.step * 1000;
    button.textContent = "Pause";
    requestAnimationFrame(tick);
  });
  slider.addEventListener("input", () => { stop(); draw(); });
  addEventListener("resize", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
}
