"""``python -m docs.studies.task_rewards``."""

from docs.studies.task_rewards.study import main

if __name__ == "__main__":
    main()
