"""What only one system offers is asked for before it is used: the package also runs where it is absent, such as on macOS."""

import ast
import ctypes
import os
import platform
import sys
from pathlib import Path

import pytest

from swarm_envs.cores import available_cores


def test_without_affinity_all_cores_of_the_machine_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert available_cores() == 6
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert available_cores() == 1


def test_a_process_that_is_confined_counts_the_cores_it_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {2, 5, 7}, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    assert available_cores() == 3


LINUX_ALONE = {
    "sched_getaffinity", "sched_setaffinity", "epoll", "eventfd", "memfd_create", "getrandom", "pidfd_open", "prlimit", "posix_fadvise",
    "posix_fallocate", "inotify_init", "SOCK_NONBLOCK", "SOCK_CLOEXEC", "SO_BINDTODEVICE", "CLOCK_BOOTTIME", "O_DIRECT", "O_TMPFILE",
}  # fmt: skip
"""Attributes of :mod:`os`, :mod:`select`, :mod:`socket` and their like that macOS does not have."""
GUARDED = {"swarm_envs/cores.py"}
"""Files that ask whether it is there."""


def test_no_module_uses_what_linux_alone_has() -> None:
    root, found = Path(__file__).parents[1], []
    for package in ("swarm_envs", "discovery", "hero_robot", "hero_firmware", "hardware"):
        for path in (root / package).rglob("*.py"):
            names = {node.attr for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Attribute)}
            if names & LINUX_ALONE and path.relative_to(root).as_posix() not in GUARDED:
                found.append((path.name, names & LINUX_ALONE))
    assert found == []


def test_memory_is_kept_only_where_the_c_library_is_asked_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("torch")
    from discovery.representations.memory import keep_freed_memory

    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr(ctypes, "CDLL", None)  # calling it would fail
    keep_freed_memory()
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(TypeError):
        keep_freed_memory()


def test_the_processor_has_a_name_where_there_is_no_proc(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("torch")
    from discovery.runs import manifest

    def absent(path: Path, encoding: str) -> str:
        raise FileNotFoundError(path)

    monkeypatch.setattr(Path, "read_text", absent)
    monkeypatch.setattr(platform, "processor", lambda: "arm")
    assert manifest._processor() == "arm"
