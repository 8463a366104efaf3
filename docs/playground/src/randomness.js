// Python's random draws, to the bit: numpy's SeedSequence, then swarm_envs/simulation/randomness.py.

const WORD = (1n << 64n) - 1n;

/** numpy's SeedSequence(seed).generate_state(1, uint64), for a seed from 0 to 2^32 - 1. */
function seedState(seed) {
  const stir = (start, factor) => {
    let constant = start;
    return (value) => {
      value ^= constant;
      constant = Math.imul(constant, factor);
      value = Math.imul(value, constant);
      return (value ^ (value >>> 16)) >>> 0;
    };
  };
  const fill = stir(0x43b0d7e5, 0x931e8875), read = stir(0x8b51f9dd, 0x58f38ded);
  const pool = [seed >>> 0, 0, 0, 0].map((word) => fill(word));
  for (let source = 0; source < 4; source++)
    for (let target = 0; target < 4; target++) {
      if (source === target) continue;
      const mixed = (Math.imul(0xca01f9dd, pool[target]) - Math.imul(0x4973f715, fill(pool[source]))) >>> 0;
      pool[target] = (mixed ^ (mixed >>> 16)) >>> 0;
    }
  const [low, high] = [read(pool[0]), read(pool[1])];
  return (BigInt(high) << 32n) | BigInt(low);
}

/** splitmix64's finaliser. */
function mix(x) {
  x = (x + 0x9e3779b97f4a7c15n) & WORD;
  x = ((x ^ (x >> 30n)) * 0xbf58476d1ce4e5b9n) & WORD;
  x = ((x ^ (x >> 27n)) * 0x94d049bb133111ebn) & WORD;
  return x ^ (x >> 31n);
}

/** Key of the draws of world `index` in a batch with `seed`. */
export function worldKey(seed, index) {
  return mix(mix(seedState(seed)) ^ BigInt(index));
}

/** A number from [0, 1) for a robot's use `stream` at the start. */
export function uniform(key, robot, stream) {
  const bits = mix(mix(mix(key ^ BigInt(stream)) ^ BigInt(robot)));
  return Number(bits >> 11n) / 2 ** 53;
}
