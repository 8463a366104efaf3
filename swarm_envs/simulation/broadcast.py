"""The one-bit broadcast, compiled: who hears whom. Nothing here runs in worlds without one."""

from __future__ import annotations

from swarm_envs.compiled import compiled
from swarm_envs.simulation.parameters import WorldArrays
from swarm_envs.simulation.state import StateArrays


@compiled(_nrt=False)
def receive_broadcast(world: WorldArrays, state: StateArrays, w: int) -> None:
    """Write each robot's last reading: whether another robot in range broadcasts."""
    poses, heard = state.poses[w], state.detections.shape[2] - 1
    for i in range(poses.shape[0]):
        state.detections[w, i, heard] = 0
        for j in range(poses.shape[0]):
            dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
            if state.messages[w, j] != 0 and j != i and dx * dx + dy * dy <= world.broadcast_range**2:
                state.detections[w, i, heard] = 1
                break


@compiled(inline="always", _nrt=False)
def broadcast_detections(state: StateArrays, w: int) -> None:
    """Let each robot broadcast whether one of its own sensors reports something, as robots with a controller do."""
    sensors = state.detections.shape[2] - 1
    for i in range(state.messages.shape[1]):
        state.messages[w, i] = 0
        for s in range(sensors):
            state.messages[w, i] |= state.detections[w, i, s]
