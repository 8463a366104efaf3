#pragma once
enum { WIFI_STA, WIFI_NONE_SLEEP };
struct ESP8266WiFiClass {
  void persistent(bool);
  bool mode(int);
  bool setSleepMode(int);
  bool setAutoReconnect(bool);
  int begin(const char *, const char *);
};
extern ESP8266WiFiClass WiFi;
