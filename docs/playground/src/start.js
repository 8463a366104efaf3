// Where robots start: distinct points of the world's centred grid, headings uniform, repeatable from a seed.

/** Small generator of numbers from 0 to 1 (mulberry32). */
function generator(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), state | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** Most robots that a world's start grid holds. */
export function places(world) {
  return world.start.columns * world.start.rows;
}

/** Poses of `count` robots. */
export function startPoses(world, count, seed) {
  const { columns, rows, spacing_x: dx, spacing_y: dy } = world.start, random = generator(seed + 1);
  const [width, height] = world.size;
  const points = [];
  for (let r = 0; r < rows; r++)
    for (let c = 0; c < columns; c++) points.push([width / 2 + (c - (columns - 1) / 2) * dx, height / 2 + (r - (rows - 1) / 2) * dy]);
  for (let i = 0; i < count; i++) {
    const j = i + Math.floor(random() * (points.length - i));
    [points[i], points[j]] = [points[j], points[i]];
  }
  return points.slice(0, count).map(([x, y]) => [x, y, 2 * Math.PI * random()]);
}
