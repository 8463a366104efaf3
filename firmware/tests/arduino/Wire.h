#pragma once
struct TwoWire {
  void begin(int, int);
  void setClock(uint32_t);
};
extern TwoWire Wire;
