// The part of the front page's address that repeats a run in the playground.

/** `#w=...` of a world by name, a controller, the number of robots, and world `index` of Python's rollouts with `seed`. */
export function address({ world, controller, robots, seed, index }) {
  return `#w=${world}&c=${[...controller].join(",")}&n=${robots}&s=${seed}` + (index ? `&i=${index}` : "");
}
