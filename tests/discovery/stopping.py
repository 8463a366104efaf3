"""Runs that are interrupted at a place of one's choice."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from discovery.command import RunContext, Stopped, run
from discovery.files import atomic
from discovery.settings import Settings


def run_until(names: str, settings: Settings, monkeypatch: pytest.MonkeyPatch) -> None:
    """Start or resume a run and interrupt it just before a file whose path holds ``names`` gets its place."""
    replace = os.replace

    def stopping(source: Path, target: Path) -> None:
        if names in str(target):
            raise Stopped(signal.SIGINT)
        replace(source, target)

    with monkeypatch.context() as patch:
        patch.setattr(atomic.os, "replace", stopping)
        with pytest.raises(Stopped):
            run(settings, given=settings.resume is None, context=RunContext())
