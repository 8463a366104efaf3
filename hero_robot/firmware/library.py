"""The firmware compiled for this machine: built with the system's C compiler on first use, kept in a cache folder."""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from hero_robot.firmware.constants import render_header
from hero_robot.firmware.errors import FirmwareError
from hero_robot.firmware.sources import firmware_folder

FLAGS = ["-std=c11", "-O2", "-Wall"]


def cache_folder() -> Path:
    """``$HERO_FIRMWARE_CACHE``, or ``hero_firmware`` in the user's cache folder."""
    given = os.environ.get("HERO_FIRMWARE_CACHE")
    if given:
        return Path(given)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hero_firmware"


def find_compiler() -> str:
    """The system's C compiler: ``$CC``, else cc, gcc or clang.

    Raises:
        FirmwareError: When there is none.
    """
    wanted = os.environ.get("CC")
    for name in [wanted] if wanted else ["cc", "gcc", "clang"]:
        path = shutil.which(name)
        if path:
            return path
    raise FirmwareError(
        f"no C compiler ({wanted or 'cc, gcc, clang'}) found; the firmware is compiled on first use: install gcc or clang, or set CC"
    )


def build(robot_file: str | Path = "hero_plus") -> Path:
    """The shared library of the core and its simulated board, with this robot's constants.

    Raises:
        FirmwareError: Without a C compiler, or when it refuses the sources.
    """
    return _compile(robot_file, "libhero.so", ["-shared", "-fPIC"], ["hal/sim/hero_sim.c"])


def build_host(robot_file: str | Path = "hero_plus") -> Path:
    """The robot as a program on this machine, with a UDP socket and simulated parts.

    Raises:
        FirmwareError: Without a C compiler, or when it refuses the sources.
    """
    return _compile(robot_file, "hero_host", [], ["hal/sim/hero_sim.c", "hal/host/main.c"])


def _compile(robot_file: str | Path, product: str, flags: list[str], extra: list[str]) -> Path:
    """Compile core and ``extra`` into ``product``; what was built before from the same text is taken from the cache."""
    folder = firmware_folder()
    sources = [*sorted((folder / "core").glob("*.c")), *(folder / name for name in extra)]
    headers = sorted(path for path in folder.glob("*/**/*.h") if path.name != "hero_config.h")
    header = render_header(robot_file)
    digest = hashlib.sha256(" ".join([*FLAGS, *flags, header]).encode())
    for path in [*sources, *headers]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    target = cache_folder() / digest.hexdigest()[:20] / product
    if not target.exists():
        _run_compiler(sources, folder / "core", header, flags, target)
    return target


def _run_compiler(sources: list[Path], core: Path, header: str, flags: list[str], target: Path) -> None:
    compiler = find_compiler()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        scratch_folder = tempfile.TemporaryDirectory(dir=target.parent)
    except OSError as error:
        raise FirmwareError(f"{target.parent}: cannot be written ({error}); set HERO_FIRMWARE_CACHE to a folder that can") from None
    with scratch_folder as name:
        scratch = Path(name)
        _lay_out(sources, core, header, scratch)
        files = [str(scratch / path.relative_to(core.parent)) for path in sources]
        built = scratch / target.name
        done = subprocess.run([compiler, *FLAGS, *flags, *files, "-lm", "-o", str(built)], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            reason = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr.strip()[:200])
            raise FirmwareError(f"{compiler} cannot build the firmware ({reason}); a C11 compiler with its standard headers is needed")
        os.replace(built, target)  # at once: another process may be building the same


def _lay_out(sources: list[Path], core: Path, header: str, scratch: Path) -> None:
    """Copy the sources beside this robot's own ``hero_config.h``."""
    for path in [*sources, *core.parent.glob("core/*.h"), *core.parent.glob("hal/*/*.h")]:
        copy = scratch / path.relative_to(core.parent)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())
    (scratch / "core" / "hero_config.h").write_text(header, encoding="utf-8")


@functools.cache
def load(robot_file: str | Path = "hero_plus") -> tuple[Any, Any]:
    """The library and its ``cffi.FFI``, built when it has to be.

    Raises:
        FirmwareError: Without cffi or a C compiler.
    """
    try:
        import cffi
    except ImportError:
        raise FirmwareError("cffi is not installed; the firmware is called through it: pip install cffi") from None
    ffi = cffi.FFI()
    ffi.cdef(_declarations(firmware_folder() / "hal" / "sim" / "hero_sim_api.h"))
    return ffi.dlopen(str(build(robot_file))), ffi


def _declarations(header: Path) -> str:
    """A C header as cffi takes it: without preprocessor lines."""
    return "\n".join(line for line in header.read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
