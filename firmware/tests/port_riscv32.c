/* Bare start for a 32-bit RISC-V under qemu-system-riscv32 -M virt: stack, write and exit through semihosting. */
#include <stdint.h>

#include "check.h"

enum { SEMIHOST_WRITE0 = 0x04, SEMIHOST_EXIT = 0x20, APPLICATION_EXIT = 0x20026 };

int main(void);
void start_in_c(void);

__asm__(
    ".section .start, \"ax\"\n"
    ".global _start\n"
    "_start:\n"
    "  la sp, _stack_top\n"
    "  call start_in_c\n"
    ".text\n");

static void semihost(int number, const void *argument) {
  register int a0 __asm__("a0") = number;
  register const void *a1 __asm__("a1") = argument;
  __asm__ volatile(
      ".option push\n .option norvc\n .balign 16\n"
      "slli zero, zero, 0x1f\n ebreak\n srai zero, zero, 7\n"
      ".option pop\n"
      : "+r"(a0)
      : "r"(a1)
      : "memory");
}

void port_write(const char *text) { semihost(SEMIHOST_WRITE0, text); }

void start_in_c(void) {
  extern uint32_t _bss_start[], _bss_end[];
  for (uint32_t *p = _bss_start; p < _bss_end; p++) *p = 0;
  uint32_t how[2] = {APPLICATION_EXIT, (uint32_t)main()};
  semihost(SEMIHOST_EXIT, how);
  for (;;) {
  }
}
