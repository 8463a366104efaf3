"use strict";
// A rollout on a canvas; shared by the report and the annotation page.
const Rollouts = (() => {
  const robotColours = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#c9b800", "#7a7f87"];
  const trailSeconds = 8;

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  // Typed arrays use the machine's byte order; every browser runs on little-endian ones.
  const int16 = (text) => new Int16Array(bytes(text).buffer);
  const float32 = (text) => new Float32Array(bytes(text).buffer);

  const colours = {};
  const readColours = () => {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["page", "card", "ink", "soft", "line", "floor", "wall", "beam"]) colours[name] = style.getPropertyValue("--" + name).trim();
    colours.of = (label) => style.getPropertyValue("--" + label.replace(" ", "-")).trim() || style.getPropertyValue("--random").trim();
  };
  readColours();

  class Rollout {
    constructor(canvas, packed, scene) {
      this.canvas = canvas;
      this.scene = scene;
      this.duration = (scene.frames - 1) * scene.interval;
      this.poses = int16(packed.poses);
      this.seen = bytes(packed.seen);
      this.visible = true;
      this.playing = true;
      this.time = 0;
    }
    fit() {
      const margin = 0.012, box = this.canvas.parentElement.clientWidth;
      const density = Math.min(window.devicePixelRatio || 1, 2);
      this.canvas.width = Math.round(box * density);
      this.canvas.height = Math.round(this.canvas.width * (this.scene.height + 2 * margin) / (this.scene.width + 2 * margin));
      this.scale = this.canvas.width / (this.scene.width + 2 * margin);
      this.margin = margin;
    }
    // y points up in the arena, down on the canvas
    x(value) { return (value + this.margin) * this.scale; }
    y(value) { return (this.scene.height + this.margin - value) * this.scale; }
    pose(frame, robot) {
      const at = Math.min(Math.floor(frame), this.scene.frames - 2), part = frame - at;
      const a = 3 * (at * this.scene.robots + robot), b = a + 3 * this.scene.robots, p = this.poses;
      let turn = p[b + 2] - p[a + 2];
      const half = Math.PI * this.scene.angle;
      if (turn > half) turn -= 2 * half;
      if (turn < -half) turn += 2 * half;
      return [(p[a] + part * (p[b] - p[a])) / this.scene.length, (p[a + 1] + part * (p[b + 1] - p[a + 1])) / this.scene.length, (p[a + 2] + part * turn) / this.scene.angle];
    }
    polygon(context, points) {
      context.beginPath();
      points.forEach(([x, y], i) => (i ? context.lineTo(this.x(x), this.y(y)) : context.moveTo(this.x(x), this.y(y))));
      context.closePath();
    }
    draw() {
      const context = this.canvas.getContext("2d"), unit = this.scale;
      const frame = Math.min(this.time / this.scene.interval, this.scene.frames - 1);
      context.clearRect(0, 0, this.canvas.width, this.canvas.height);
      context.fillStyle = colours.floor;
      context.fillRect(0, 0, this.canvas.width, this.canvas.height);
      context.lineJoin = context.lineCap = "round";
      this.polygon(context, this.scene.arena);
      context.lineWidth = 0.008 * unit;
      context.strokeStyle = colours.wall;
      context.stroke();
      context.fillStyle = colours.line;
      for (const obstacle of this.scene.obstacles) { this.polygon(context, obstacle); context.fill(); }
      for (let robot = 0; robot < this.scene.robots; robot++) this.drawTrail(context, frame, robot);
      for (let robot = 0; robot < this.scene.robots; robot++) this.drawRobot(context, frame, robot);
    }
    drawTrail(context, frame, robot) {
      const pieces = 6, length = trailSeconds / this.scene.interval;
      context.strokeStyle = robotColours[robot % robotColours.length];
      context.lineWidth = 0.007 * this.scale;
      for (let piece = 0; piece < pieces; piece++) {
        const from = frame - length * (1 - piece / pieces), to = frame - length * (1 - (piece + 1) / pieces);
        if (to <= 0) continue;
        context.globalAlpha = 0.08 + 0.5 * (piece + 1) / pieces;
        context.beginPath();
        for (let k = Math.max(from, 0), first = true; ; k = Math.min(k + 1, to), first = false) {
          const [x, y] = this.pose(k, robot);
          first ? context.moveTo(this.x(x), this.y(y)) : context.lineTo(this.x(x), this.y(y));
          if (k >= to) break;
        }
        context.stroke();
      }
      context.globalAlpha = 1;
    }
    drawRobot(context, frame, robot) {
      const [px, py, heading] = this.pose(frame, robot), x = this.x(px), y = this.y(py);
      const contact = this.scene.contact[robot] * this.scale, body = this.scene.body[robot] * this.scale;
      const seen = this.seen[Math.floor(frame) * this.scene.robots + robot], colour = robotColours[robot % robotColours.length];
      if (seen) {
        context.fillStyle = colours.beam;
        context.globalAlpha = 0.22;
        for (const [bearing, half, range] of this.scene.sensors[robot]) {
          const reach = Math.min(range, 0.32) * this.scale, middle = -(heading + bearing);
          context.beginPath();
          context.moveTo(x, y);
          context.arc(x, y, reach, middle - half, middle + half);
          context.fill();
        }
        context.globalAlpha = 1;
      }
      context.lineWidth = Math.max(1, 0.006 * this.scale);
      context.strokeStyle = context.fillStyle = colour;
      context.beginPath();
      context.arc(x, y, Math.max(contact - context.lineWidth / 2, 1), 0, 7);
      context.globalAlpha = seen ? 1 : 0.12;
      context.fill();
      context.globalAlpha = 1;
      context.stroke();
      if (!seen) {
        context.globalAlpha = 0.4;
        context.beginPath();
        context.arc(x, y, body, 0, 7);
        context.fill();
        context.globalAlpha = 1;
      }
      context.strokeStyle = seen ? "#ffffff" : colours.ink;
      context.lineWidth = Math.max(1.2, 0.009 * this.scale);
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(x + contact * 0.86 * Math.cos(heading), y - contact * 0.86 * Math.sin(heading));
      context.stroke();
    }
  }

  return { Rollout, bytes, int16, float32, colours, readColours };
})();
