#pragma once
struct WiFiUDP {
  uint8_t begin(uint16_t);
  int parsePacket();
  int read(unsigned char *, size_t);
  IPAddress remoteIP();
  uint16_t remotePort();
  int beginPacket(IPAddress, uint16_t);
  size_t write(const uint8_t *, size_t);
  int endPacket();
};
