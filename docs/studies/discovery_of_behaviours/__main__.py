"""``python -m docs.studies.discovery_of_behaviours``."""

from docs.studies.discovery_of_behaviours.command import main

if __name__ == "__main__":
    raise SystemExit(main())
