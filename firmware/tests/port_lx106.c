/* Bare start for the ESP8266's CPU under qemu-system-xtensa -M sim: stack, write and exit through `simcall`. */
#include <stdint.h>

#include "check.h"

enum { SIMCALL_EXIT = 1, SIMCALL_WRITE = 4 };

int main(void);
void start_in_c(void);

__asm__(
    ".section .start, \"ax\"\n"
    ".global _start\n"
    ".literal_position\n"
    "_start:\n"
    "  movi a1, _stack_top\n"
    "  call0 start_in_c\n"
    ".text\n");

static int simcall(int number, int a, int b, int c) {
  register int r2 __asm__("a2") = number;
  register int r3 __asm__("a3") = a;
  register int r4 __asm__("a4") = b;
  register int r5 __asm__("a5") = c;
  __asm__ volatile("simcall" : "+r"(r2), "+r"(r3) : "r"(r4), "r"(r5) : "memory");
  return r2;
}

void port_write(const char *text) {
  int size = 0;
  while (text[size] != '\0') size++;
  simcall(SIMCALL_WRITE, 1, (int)text, size);
}

void start_in_c(void) {
  extern uint32_t _bss_start[], _bss_end[];
  for (uint32_t *p = _bss_start; p < _bss_end; p++) *p = 0;
  simcall(SIMCALL_EXIT, main(), 0, 0);
  for (;;) {
  }
}
