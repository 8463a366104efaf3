// Declarations of the Arduino core for the ESP8266 that the glue calls: enough to check its types, nothing behind them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>

#define IRAM_ATTR
#define RANDOM_REG32 (*static_cast<volatile uint32_t *>(nullptr))
enum { LOW, HIGH, INPUT_PULLUP, OUTPUT, CHANGE, A0 = 17 };

unsigned long micros();
unsigned long millis();
uint64_t micros64();
void delay(unsigned long);
void noInterrupts();
void interrupts();
void digitalWrite(uint8_t, uint8_t);
void pinMode(uint8_t, uint8_t);
int analogRead(uint8_t);
uint8_t digitalPinToInterrupt(uint8_t);
void attachInterrupt(uint8_t, void (*)(), int);

struct IPAddress {
  explicit IPAddress(uint32_t);
  operator uint32_t() const;
};
