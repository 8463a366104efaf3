// The map of an archive on a canvas: points coloured by behaviour, zoomed and moved.

const MARGIN = 0.03;
const MOST = 40;
/** How far from a point, in pixels of the page, a pointer still means it. */
const REACH = 14;

export class ArchiveMap {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Archive} archive
   */
  constructor(canvas, archive) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.archive = archive;
    this.shown = archive.labels.map(() => true);
    this.whole();
  }

  /** Show all of the map. */
  whole() {
    this.zoom = 1;
    this.centre = [0.5, 0.5];
  }

  /** Fit the canvas to its place on the page. */
  fit() {
    this.density = window.devicePixelRatio || 1;
    this.canvas.width = this.canvas.height = Math.round(this.canvas.clientWidth * this.density);
  }

  get scale() {
    return (this.canvas.width / (1 + 2 * MARGIN)) * this.zoom;
  }

  /** Pixels of the canvas of a place. */
  at([x, y]) {
    const middle = this.canvas.width / 2;
    return [middle + (x - this.centre[0]) * this.scale, middle - (y - this.centre[1]) * this.scale];
  }

  /** Pixels of the canvas under a pointer event. */
  pixel(event) {
    const box = this.canvas.getBoundingClientRect(), ratio = this.canvas.width / box.width;
    return [(event.clientX - box.left) * ratio, (event.clientY - box.top) * ratio];
  }

  /** Zoom by a factor about a pixel of the canvas, by default its middle. */
  zoomBy(factor, [px, py] = [this.canvas.width / 2, this.canvas.height / 2]) {
    const before = this.scale, middle = this.canvas.width / 2;
    this.zoom = Math.max(1, Math.min(MOST, this.zoom * factor));
    const after = this.scale;
    this.moveTo(
      this.centre[0] + (px - middle) * (1 / before - 1 / after),
      this.centre[1] - (py - middle) * (1 / before - 1 / after),
    );
  }

  /** Move by pixels of the canvas. */
  moveBy(dx, dy) {
    this.moveTo(this.centre[0] - dx / this.scale, this.centre[1] + dy / this.scale);
  }

  moveTo(x, y) {
    const room = 0.5 - 0.5 / this.zoom;
    this.centre = [x, y].map((value) => Math.max(0.5 - room, Math.min(0.5 + room, value)));
  }

  /** Bring a row into view. */
  reveal(row) {
    const [px, py] = this.at(this.archive.place(row)), width = this.canvas.width, edge = 0.05 * width;
    if (Math.min(px, py) < edge || Math.max(px, py) > width - edge) this.moveTo(...this.archive.place(row));
  }

  /** The row nearest to a pixel, -1 where there is none in reach. */
  nearest([px, py]) {
    let best = (REACH * this.density) ** 2, found = -1;
    for (let row = 0; row < this.archive.size; row++) {
      if (!this.shown[this.archive.label[row]]) continue;
      const [x, y] = this.at(this.archive.place(row)), squared = (x - px) ** 2 + (y - py) ** 2;
      if (squared < best) [best, found] = [squared, row];
    }
    return found;
  }

  /** The next shown row from `row` in a direction, -1 where there is none: near, and more along than across. */
  next(row, [dx, dy]) {
    const [x, y] = this.archive.place(row);
    let best = Infinity, found = -1;
    for (let other = 0; other < this.archive.size; other++) {
      if (other === row || !this.shown[this.archive.label[other]]) continue;
      const [ox, oy] = this.archive.place(other), along = (ox - x) * dx + (oy - y) * dy, across = Math.abs((ox - x) * dy - (oy - y) * dx);
      if (along <= across || along < 1e-9) continue;
      const cost = along + 2 * across;
      if (cost < best) [best, found] = [cost, other];
    }
    return found;
  }

  /** Draw with a row under the pointer and a chosen one (-1: none). */
  draw(pointed, chosen) {
    const { context, canvas, archive, density } = this, style = getComputedStyle(canvas);
    const colour = (name) => style.getPropertyValue(`--swarm-${name}`).trim();
    context.fillStyle = colour("floor");
    context.fillRect(0, 0, canvas.width, canvas.height);
    const radius = Math.min(5, 1.6 * Math.sqrt(this.zoom)) * density, order = archive.labels.map((_, k) => k).reverse(); // random below
    for (const label of order) {
      if (!this.shown[label]) continue;
      context.fillStyle = colour(`label-${archive.labels[label].replace(" ", "-")}`);
      context.beginPath();
      for (let row = 0; row < archive.size; row++) {
        if (archive.label[row] !== label) continue;
        const [x, y] = this.at(archive.place(row));
        if (x < -radius || y < -radius || x > canvas.width + radius || y > canvas.height + radius) continue;
        context.moveTo(x + radius, y);
        context.arc(x, y, radius, 0, 2 * Math.PI);
      }
      context.fill();
    }
    archive.medoids.forEach(({ row }, k) => this.drawMedoid(row, k + 1, colour));
    if (pointed >= 0 && pointed !== chosen) this.drawRing(pointed, 6 * density, 2, colour("wall"));
    if (chosen >= 0) this.drawRing(chosen, 8 * density, 3, colour("ink"));
  }

  drawRing(row, radius, width, colour) {
    const { context } = this, [x, y] = this.at(this.archive.place(row));
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.lineWidth = width * this.density;
    context.strokeStyle = colour;
    context.stroke();
  }

  drawMedoid(row, number, colour) {
    const { context, density } = this, [x, y] = this.at(this.archive.place(row)), radius = 9 * density;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = colour("floor");
    context.fill();
    this.drawRing(row, radius, 2, colour(`label-${this.archive.name(row).replace(" ", "-")}`));
    context.fillStyle = colour("ink");
    context.font = `${11 * density}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(number, x, y);
  }
}
