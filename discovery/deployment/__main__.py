"""``python -m discovery.deployment``: the old name of ``python -m hero_robot.fleet``."""

import sys

from hero_robot.fleet.command import main

print("python -m discovery.deployment is now python -m hero_robot.fleet; use that", file=sys.stderr)
sys.exit(main())
