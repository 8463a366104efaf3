"""The study of the tasks' rewards: its command works, and its page tells of every task."""

from __future__ import annotations

import re

import pytest

from docs.studies.marked_page import between_marks
from docs.studies.task_rewards import study
from swarm_envs.envs.tasks import TASKS


def test_a_small_study_prints_a_row_for_each_task(capsys: pytest.CaptureFixture[str]) -> None:
    study.main(["--controllers", "60", "--print"])
    rows = re.findall(r"^\| `HeRo/(\w+)-v0` \| (\d+) \| ([\d.]*) \| ([\d.]+) \|$", capsys.readouterr().out, flags=re.MULTILINE)
    assert [row[0] for row in rows] == list(TASKS)
    assert all(own == "" or float(own) > float(every) for _, _, own, every in rows)
    assert sum(int(count) for _, count, _, _ in rows) > 0


def test_the_page_says_that_each_task_pays_its_own_behaviour_more_than_others() -> None:
    rows = re.findall(r"`HeRo/(\w+)-v0` \| \d+ \| ([\d.]+) \| ([\d.]+) \|", between_marks(study.PAGE, "results"))
    assert [row[0] for row in rows] == list(TASKS)
    assert all(float(own) > 1.5 * float(every) for _, own, every in rows)
