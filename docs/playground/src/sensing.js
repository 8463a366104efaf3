// The binary line-of-sight sensor: is the centre of some robot in range, and does its visible disc meet the sector?

/**
 * Whether a robot at `me` sees one at `other`.
 * @param {number[]} me x and y in m, heading in rad
 * @param {number[]} other x and y in m
 * @param {{half_angle: number, range: number, bearing: number}} sensor rad, m, rad
 * @param {number} radius of the visible disc in m
 */
export function sees(me, other, sensor, radius) {
  const dx = other[0] - me[0], dy = other[1] - me[1];
  const axis = me[2] + sensor.bearing;
  const ax = Math.cos(axis), ay = Math.sin(axis);
  const along = ax * dx + ay * dy, across = Math.abs(ax * dy - ay * dx);
  const cosHalf = Math.cos(sensor.half_angle), sinHalf = Math.sin(sensor.half_angle);
  // signed distance from the line of the edge ray, positive outside the sector
  const outside = across * cosHalf - along * sinHalf;
  if (outside > radius) return false;
  const squared = along * along + across * across;
  if (squared > sensor.range * sensor.range) return false;
  if (along * cosHalf + across * sinHalf >= 0) return true;
  // behind the edge ray's start: inside a sector wider than a half-plane, else only the apex can be met
  return (cosHalf < 0 && outside <= 0) || squared <= radius * radius;
}

/** One boolean a robot: does it see another? */
export function detect(poses, world) {
  return poses.map((me, i) => poses.some((other, j) => j !== i && sees(me, other, world.sensor, world.visible_radius)));
}
