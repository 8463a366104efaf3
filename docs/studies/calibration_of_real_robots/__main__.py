"""``python -m docs.studies.calibration_of_real_robots``."""

from docs.studies.calibration_of_real_robots.study import main

if __name__ == "__main__":
    main()
