"""``python -m docs.studies.wall_following_and_milling``."""

from docs.studies.wall_following_and_milling.study import main

if __name__ == "__main__":
    main()
