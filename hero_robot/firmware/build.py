"""Sizes, tests and fuzzing of the firmware: ``python -m hero_robot.firmware.build --sizes | --test | --fuzz N``."""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from hero_robot.firmware.errors import FirmwareError
from hero_robot.firmware.sources import firmware_folder

TEXT_BUDGET = 16_384
"""Most bytes of code and constants that the core may take on any of the CPUs: half of the ESP8266's instruction RAM."""

RAM_BUDGET = 2_048
"""Most bytes of RAM that the whole state of a robot may take: 2.5 % of the ESP8266's 80 KiB."""


@dataclass(frozen=True)
class Target:
    """A CPU that the core is compiled for."""

    name: str
    prefix: str
    flags: tuple[str, ...]
    specs: str
    packages: str


TARGETS = [
    Target(
        "lx106 (ESP8266)",
        "xtensa-lx106-elf-",
        ("-mlongcalls", "-mtext-section-literals"),
        "/usr/lib/xtensa-lx106-elf/picolibc.specs",
        "gcc-xtensa-lx106 picolibc-xtensa-lx106-elf",
    ),
    Target(
        "riscv32 (ESP32-C3)",
        "riscv64-unknown-elf-",
        ("-march=rv32imac", "-mabi=ilp32"),
        "/usr/lib/picolibc/riscv64-unknown-elf/picolibc.specs",
        "gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf",
    ),
]


@dataclass(frozen=True)
class Sizes:
    """What the core takes on one CPU."""

    text: int
    """Bytes of code and constants."""
    data: int
    """Bytes of initialised and zeroed variables of the core itself."""
    robot: int
    """Bytes of one ``struct hero_robot``: all the state there is."""


def measure(target: Target) -> Sizes | None:
    """Compile the core for ``target`` and add up its sections; None when its tools are absent.

    Raises:
        FirmwareError: When the core does not compile.
    """
    compiler = shutil.which(target.prefix + "gcc")
    if compiler is None or not Path(target.specs).is_file():
        return None
    core = firmware_folder() / "core"
    with tempfile.TemporaryDirectory() as name:
        probe = Path(name) / "probe.c"
        probe.write_text('#include "hero_robot.h"\nchar probe[sizeof(struct hero_robot)];\n')
        flags = [f"--specs={target.specs}", "-std=c11", "-Os", "-ffreestanding", *target.flags, "-I", str(core), "-c"]
        sources = [*sorted(core.glob("*.c")), probe]
        done = subprocess.run([compiler, *flags, *map(str, sources)], cwd=name, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise FirmwareError(f"{target.name}: the core does not compile ({done.stderr.strip().splitlines()[0]})")
        objects = [path.with_suffix(".o").name for path in sources]
        listing = subprocess.run([target.prefix + "size", *objects], cwd=name, capture_output=True, text=True, check=True).stdout
    rows = [[int(number) for number in line.split()[:3]] for line in listing.splitlines()[1:]]
    own = rows[:-1]
    return Sizes(text=sum(row[0] for row in own), data=sum(row[1] + row[2] for row in own), robot=rows[-1][1] + rows[-1][2])


def print_sizes() -> int:
    """Print a line for each CPU; 1 when a budget is exceeded."""
    status = 0
    for target in TARGETS:
        sizes = measure(target)
        if sizes is None:
            print(f"{target.name}: not measured, its compiler is absent (Debian: {target.packages})")
            continue
        print(f"{target.name}: core text {sizes.text} bytes of {TEXT_BUDGET}, RAM {sizes.data + sizes.robot} bytes of {RAM_BUDGET}")
        if sizes.text > TEXT_BUDGET or sizes.data + sizes.robot > RAM_BUDGET:
            status = 1
    return status


def build_tests(build: Path) -> None:
    """Configure and compile the C tests in the folder ``build``.

    Raises:
        FirmwareError: Without CMake, or when they do not compile.
    """
    if shutil.which("cmake") is None:
        raise FirmwareError("cmake is absent; the C tests need it (Debian: cmake)")
    commands = [
        ["cmake", "-S", str(firmware_folder()), "-B", str(build)],
        ["cmake", "--build", str(build)],
    ]
    for command in commands:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise FirmwareError(f"{' '.join(command)} failed: {(done.stderr or done.stdout).strip()[-800:]}")


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m hero_robot.firmware.build", description=__doc__)
    parser.add_argument("--sizes", action="store_true", help="print code and RAM of the core on each CPU")
    parser.add_argument("--test", action="store_true", help="build and run the C tests, on the host and under qemu")
    parser.add_argument("--fuzz", type=int, metavar="N", help="N fuzzed frames under the sanitizers, with libFuzzer too where clang is")
    parser.add_argument("--build", type=Path, default=Path("build/firmware"), help="folder of the compiled tests")
    given = parser.parse_args(arguments)
    if not (given.sizes or given.test or given.fuzz):
        parser.error("give --sizes, --test or --fuzz N")
    status = 0
    try:
        if given.sizes:
            status |= print_sizes()
        if given.test or given.fuzz:
            build_tests(given.build)
        if given.test:
            status |= subprocess.run(["ctest", "--test-dir", str(given.build), "--output-on-failure"], check=False).returncode
        if given.fuzz:
            status |= _fuzz(given.build, given.fuzz)
    except FirmwareError as error:
        print(error, file=sys.stderr)
        return 2
    return 1 if status else 0


def _fuzz(build: Path, frames: int) -> int:
    """Seeded frames, then as many of libFuzzer's own."""
    status = subprocess.run([build / "fuzz_seeded", str(frames)], check=False).returncode
    if shutil.which("clang") is None:
        print("libFuzzer: skipped, clang is absent (Debian: clang libclang-rt-14-dev)")
        return status
    subprocess.run(["cmake", "--build", str(build), "--target", "libfuzzer"], check=True, stdout=subprocess.DEVNULL)
    command = [str(build / "fuzz_frame"), f"-runs={frames}", "-max_len=180", "-verbosity=0", "-print_final_stats=1"]
    return status | subprocess.run(command, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
