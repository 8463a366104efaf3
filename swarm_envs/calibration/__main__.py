"""``python -m swarm_envs.calibration`` is ``swarm-calibrate``."""

import sys

from swarm_envs.calibration.command import main

sys.exit(main())
