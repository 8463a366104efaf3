#!/bin/sh
# Builds the core's unit tests for a bare CPU and runs them under qemu.  Usage: run_on.sh lx106|riscv32 BUILD_FOLDER
# Exit status: 0 passed, 1 failed, 77 skipped because a tool is absent (its name is printed).
set -eu
machine=$1
build=$2
firmware=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$build"

need() {
  command -v "$1" >/dev/null || {
    echo "skipped: $1 is absent (Debian: $2)"
    exit 77
  }
}

case $machine in
  lx106)
    need xtensa-lx106-elf-gcc gcc-xtensa-lx106
    need qemu-system-xtensa qemu-system-misc
    specs=/usr/lib/xtensa-lx106-elf/picolibc.specs
    compiler="xtensa-lx106-elf-gcc -mlongcalls -mtext-section-literals"
    run="qemu-system-xtensa -M sim -cpu lx106 -nographic -monitor none -semihosting -device loader,cpu-num=0,file=$build/tests.elf"
    ;;
  riscv32)
    need riscv64-unknown-elf-gcc gcc-riscv64-unknown-elf
    need qemu-system-riscv32 qemu-system-misc
    specs=/usr/lib/picolibc/riscv64-unknown-elf/picolibc.specs
    compiler="riscv64-unknown-elf-gcc -march=rv32imac -mabi=ilp32"
    run="qemu-system-riscv32 -M virt -bios none -nographic -monitor none -serial none -semihosting-config enable=on,target=native -kernel $build/tests.elf"
    ;;
  *)
    echo "machine '$machine' is unknown; give lx106 or riscv32"
    exit 1
    ;;
esac
[ -f "$specs" ] || {
  echo "skipped: $specs is absent (Debian: picolibc-xtensa-lx106-elf, picolibc-riscv64-unknown-elf)"
  exit 77
}

# shellcheck disable=SC2086
$compiler --specs="$specs" -std=c11 -Os -ffreestanding -fno-builtin-printf -Wall -Wextra -nostartfiles \
  -Wl,--no-warn-rwx-segments -T "$firmware/tests/$machine.ld" "$firmware"/core/*.c "$firmware"/tests/test_*.c "$firmware"/tests/check.c \
  "$firmware"/tests/*_"$machine".c -o "$build/tests.elf"
# shellcheck disable=SC2086
timeout 100 $run </dev/null
