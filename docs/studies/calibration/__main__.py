"""``python -m docs.studies.calibration``."""

from docs.studies.calibration.study import main

if __name__ == "__main__":
    main()
