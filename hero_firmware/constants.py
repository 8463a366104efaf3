"""The old name of :mod:`hero_robot.firmware.constants`, kept for one version."""

from hero_robot.firmware.constants import *  # noqa: F403
from hero_robot.firmware.constants import main

if __name__ == "__main__":
    main()
