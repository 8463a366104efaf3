// Where robots start: distinct points of the world's centred grid, headings uniform; the same as Python's for the same seed.

import { uniform, worldKey } from "./randomness.js";

const STREAM_POINT = 96;
const STREAM_HEADING = 97;

/** Most robots that a world's start grid holds. */
export function places(world) {
  return world.start.columns * world.start.rows;
}

/** Poses of `count` robots: those of world `index` of Python's rollouts with `seed`. */
export function startPoses(world, count, seed, index = 0) {
  const { columns, rows, spacing_x: dx, spacing_y: dy } = world.start, key = worldKey(seed, index);
  const [width, height] = world.size;
  const points = [];
  for (let r = 0; r < rows; r++)
    for (let c = 0; c < columns; c++) points.push([width / 2 + (c - (columns - 1) / 2) * dx, height / 2 + (r - (rows - 1) / 2) * dy]);
  for (let i = 0; i < count; i++) {
    const j = i + Math.floor(uniform(key, i, STREAM_POINT) * (points.length - i));
    [points[i], points[j]] = [points[j], points[i]];
  }
  return points.slice(0, count).map(([x, y], i) => [x, y, 2 * Math.PI * uniform(key, i, STREAM_HEADING)]);
}
