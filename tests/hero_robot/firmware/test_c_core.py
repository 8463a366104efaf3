"""The core's C tests: on this machine with sanitizers, and on the ESP8266's and the ESP32-C3's CPU under qemu."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from hero_robot.firmware.build import RAM_BUDGET, TARGETS, TEXT_BUDGET, Target, build_tests, measure
from hero_robot.firmware.sources import core_folder, firmware_folder

FUZZ_FRAMES = 200_000


@pytest.fixture(scope="module")
def build(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if shutil.which("cmake") is None:
        pytest.skip("cmake is absent (Debian: cmake)")
    folder = tmp_path_factory.mktemp("c_core")
    build_tests(folder)
    return folder


def test_the_core_passes_its_tests_under_sanitizers(build: Path) -> None:
    done = subprocess.run([build / "hero_tests"], capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    found = re.search(r"(\d+) checks, 0 failures", done.stdout)
    assert found is not None
    assert int(found[1]) > 200_000


@pytest.mark.parametrize("machine", ["lx106", "riscv32"])
def test_the_core_passes_its_tests_on_the_robots_cpu(machine: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [firmware_folder() / "tests" / "run_on.sh", machine, tmp_path], capture_output=True, text=True, check=False, timeout=120
    )
    if done.returncode == 77:
        pytest.skip(done.stdout.strip())
    assert done.returncode == 0, done.stdout + done.stderr
    assert ", 0 failures" in done.stdout + done.stderr  # semihosting writes to standard error


def test_fuzzed_frames_do_no_harm_under_sanitizers(build: Path) -> None:
    done = subprocess.run([build / "fuzz_seeded", str(FUZZ_FRAMES)], capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{FUZZ_FRAMES} frames, no fault" in done.stdout


def test_the_libfuzzer_target_builds_and_runs(build: Path) -> None:
    if shutil.which("clang") is None:
        pytest.skip("clang is absent (Debian: clang libclang-rt-14-dev)")
    made = subprocess.run(["cmake", "--build", build, "--target", "libfuzzer"], capture_output=True, text=True, check=False)
    if made.returncode != 0 and "clang_rt" in made.stderr:
        pytest.skip("clang's fuzzer runtime is absent (Debian: libclang-rt-14-dev)")
    assert made.returncode == 0, made.stderr
    # libFuzzer reads its peak memory with what the process that started it had peaked at, torch and all: no limit on that
    command = [build / "fuzz_frame", "-runs=50000", "-max_len=180", "-seed=1", "-rss_limit_mb=0"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stderr[-2000:]


def test_the_esp8266_glue_fits_the_core(build: Path) -> None:
    done = subprocess.run(["ctest", "--test-dir", build, "-R", "glue", "--output-on-failure"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_the_core_fits_its_budget(target: Target) -> None:
    sizes = measure(target)
    if sizes is None:
        pytest.skip(f"its compiler is absent (Debian: {target.packages})")
    assert 2_000 < sizes.text <= TEXT_BUDGET
    assert sizes.data == 0, "the core keeps no state of its own"
    assert sizes.robot <= RAM_BUDGET


def test_the_core_has_no_heap_no_clock_no_float() -> None:
    for path in core_folder().glob("*.[ch]"):
        text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        found = re.findall(r"\b(malloc|calloc|free|float|double|millis|micros|time|clock|Arduino)\b\s*[(\w]", text)
        assert not found, f"{path.name}: {found}"
        assert not re.findall(r"\d\.\d", text), path.name
        assert set(re.findall(r"#include <(.+?)>", text)) <= {"stdint.h", "stdbool.h", "stddef.h", "string.h"}, path.name
