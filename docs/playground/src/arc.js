// The motion of a robot that nothing touches: the exact arc of a unicycle.

/** sin(x) / x, by its series where the quotient would lose digits. */
function sinc(x) {
  return Math.abs(x) > 1e-4 ? Math.sin(x) / x : 1 - (x * x) / 6;
}

/**
 * Mean velocity {x, y} in m/s over `duration` s of a robot that drives v m/s and omega rad/s from `heading` rad:
 * moved with it in a straight line, the robot ends where its arc ends.
 */
export function meanVelocity(heading, v, omega, duration) {
  const halfTurn = 0.5 * omega * duration;
  const chord = v * sinc(halfTurn);
  return { x: chord * Math.cos(heading + halfTurn), y: chord * Math.sin(heading + halfTurn) };
}
