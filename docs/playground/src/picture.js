// Draws the swarm on a canvas: the floor, trails, sensor beams and robots. y points up in the world, down on the canvas.

const MARGIN = 0.03;

/** Colours of the page's present theme, from its style sheet. */
function colours(canvas) {
  const style = getComputedStyle(canvas);
  const names = ["floor", "wall", "robot", "seeing", "heading", "trail", "beam"];
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--swarm-${name}`).trim()]));
}

export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  /** Fit the canvas to its place on the page and to a world's floor. */
  fit(world) {
    const [width, height] = world.size;
    this.height = height;
    const pixels = this.canvas.clientWidth * (window.devicePixelRatio || 1);
    this.scale = pixels / (width + 2 * MARGIN);
    this.canvas.width = Math.round(pixels);
    this.canvas.height = Math.round((height + 2 * MARGIN) * this.scale);
  }

  /** Pixels of a point in m. */
  at(x, y) {
    return [(x + MARGIN) * this.scale, (this.height - y + MARGIN) * this.scale];
  }

  /** The point in m under a pointer event. */
  point(event) {
    const box = this.canvas.getBoundingClientRect();
    const scale = this.canvas.width / box.width / this.scale;
    return [(event.clientX - box.left) * scale - MARGIN, this.height + MARGIN - (event.clientY - box.top) * scale];
  }

  draw(swarm, trails, chosen) {
    const { context, canvas, scale } = this, { world } = swarm, palette = colours(canvas);
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.beginPath();
    world.outline.forEach(([x, y], k) => context[k ? "lineTo" : "moveTo"](...this.at(x, y)));
    context.closePath();
    context.fillStyle = palette.floor;
    context.fill();
    context.lineWidth = 0.01 * scale;
    context.strokeStyle = palette.wall;
    context.stroke();
    context.save();
    context.clip(); // beams reach beyond the walls, which are below them; the picture ends there
    this.drawTrails(trails, palette);
    swarm.poses().forEach((pose, i) => this.drawBeam(pose, swarm.detections[i], world, palette));
    context.restore();
    swarm.poses().forEach((pose, i) => this.drawRobot(pose, swarm.detections[i], world, palette, i === chosen));
  }

  drawTrails(trails, palette) {
    const { context, scale } = this;
    context.strokeStyle = palette.trail;
    context.lineWidth = 0.008 * scale;
    trails.forEach((trail) => {
      context.beginPath();
      trail.forEach(([x, y], k) => context[k ? "lineTo" : "moveTo"](...this.at(x, y)));
      context.stroke();
    });
  }

  drawBeam([x, y, heading], seeing, world, palette) {
    const { context, scale } = this, [px, py] = this.at(x, y);
    const axis = -(heading + world.sensor.bearing), half = world.sensor.half_angle;
    context.beginPath();
    context.moveTo(px, py);
    context.arc(px, py, world.sensor.range * scale, axis - half, axis + half);
    context.closePath();
    context.globalAlpha = seeing ? 0.22 : 0.06;
    context.fillStyle = seeing ? palette.seeing : palette.beam;
    context.fill();
    context.globalAlpha = 1;
  }

  drawRobot([x, y, heading], seeing, world, palette, chosen) {
    const { context, scale } = this, [px, py] = this.at(x, y), radius = world.contact_radius * scale;
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.fillStyle = seeing ? palette.seeing : palette.robot;
    context.fill();
    if (chosen) {
      context.lineWidth = 0.012 * scale;
      context.strokeStyle = palette.heading;
      context.stroke();
    }
    context.beginPath();
    context.moveTo(px, py);
    context.lineTo(px + radius * Math.cos(heading), py - radius * Math.sin(heading));
    context.lineWidth = 0.014 * scale;
    context.strokeStyle = palette.heading;
    context.stroke();
  }
}
