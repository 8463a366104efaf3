"""``read_log``: a log from whatever it was recorded in."""

from __future__ import annotations

from pathlib import Path

from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.bags import bags_in, read_bags
from swarm_envs.calibration.logs.folder import read_folder
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.logs.topics import TopicMap


def read_log(*sources: str | Path, topics: str | Path | TopicMap | None = None) -> Log:
    """Return the log in a folder or in ROS bags.

    Args:
        sources: A folder with ``log.yaml`` and the tables; or ROS 1 or ROS 2 bags, or folders of them, each bag a run.
        topics: For bags: which topics are what, a map or its YAML file; guessed by name and type where absent.

    Raises:
        LogError: When something cannot be used; one line with file, row and reason.
    """
    folders = [Path(source) for source in sources]
    for folder in folders:
        if not folder.exists():
            raise LogError(f"{folder}: no such folder; give a log folder with log.yaml, poses and commands, or a ROS bag")
    bags = [bag for folder in folders if not (folder / "log.yaml").is_file() for bag in bags_in(folder)]
    if not bags:
        if len(folders) != 1:
            raise LogError(f"given {len(folders)} sources without a ROS bag among them, expected one log folder, or bags")
        if topics is not None:
            raise LogError(f"{folders[0]}: a topic map is given, but no ROS bag; leave --topics out for a log folder")
        return read_folder(folders[0])
    others = [folder for folder in folders if (folder / "log.yaml").is_file() or not bags_in(folder)]
    if others:
        raise LogError(f"{others[0]}: not a ROS bag, given among bags; give bags alone, or one log folder")
    return read_bags(bags, topics)
