// The HeRo+ on its ESP8266: the ten functions that the core asks for, and nothing else.
//
// Nothing here decides anything. Servo pulses come from the hardware timer's interrupt and end by themselves after
// HERO_SERVO_REFRESH_US, so a loop that hangs cannot leave a robot driving.
#include <Arduino.h>
#include <ESP8266WiFi.h>
#include <VL53L1X.h>
#include <WiFiUdp.h>
#include <Wire.h>
#include <core_esp8266_waveform.h>

extern "C" {
#include "hero_config.h"
#include "hero_robot.h"
}
#include "secrets.h"

static const uint32_t SERVO_FRAME_US = 20000;       // a servo's frame: 50 pulses a second
static const uint32_t BATTERY_PERIOD_MS = 250;      // the converter disturbs the radio when it is asked too often
static const uint32_t RANGE_WAKE_MS = 2;            // boot time of the VL53L1X after its shutdown pin rises (datasheet: 1.2 ms)
static const uint8_t SERVO_PIN[2] = {HERO_PIN_SERVO_LEFT, HERO_PIN_SERVO_RIGHT};
static const uint8_t ENCODER_PIN[2] = {HERO_PIN_ENCODER_LEFT, HERO_PIN_ENCODER_RIGHT};

static struct hero_robot robot;
static WiFiUDP udp;
static VL53L1X ranger;
static bool ranger_ready;
static volatile uint32_t edges[2], edge_us[2];

static IRAM_ATTR void left_edge() {
  edges[HERO_LEFT] = edges[HERO_LEFT] + 1;
  edge_us[HERO_LEFT] = micros();
}

static IRAM_ATTR void right_edge() {
  edges[HERO_RIGHT] = edges[HERO_RIGHT] + 1;
  edge_us[HERO_RIGHT] = micros();
}

static uint8_t digit(char c) { return c <= '9' ? c - '0' : (c | 32) - 'a' + 10; }

static bool load_settings(void *, struct hero_settings *settings) {
  const char *hex = HERO_KEY;
  if (strlen(hex) != 2 * HERO_KEY_SIZE) return false;
  settings->robot = HERO_ROBOT;
  for (unsigned i = 0; i < HERO_KEY_SIZE; i++) settings->key[i] = digit(hex[2 * i]) << 4 | digit(hex[2 * i + 1]);
  settings->halt_us[HERO_LEFT] = HERO_HALT_LEFT_US;
  settings->halt_us[HERO_RIGHT] = HERO_HALT_RIGHT_US;
  return true;
}

// The radio's noise feeds this register; it is on before the core boots.
static uint64_t random64(void *) { return (uint64_t)RANDOM_REG32 << 32 | RANDOM_REG32; }

static void servo_write(void *, int side, uint16_t pulse_us) {
  static uint16_t last[2];
  if (pulse_us == 0) {
    if (last[side] != 0) stopWaveform(SERVO_PIN[side]);
  } else {
    startWaveform(SERVO_PIN[side], pulse_us, SERVO_FRAME_US - pulse_us, HERO_SERVO_REFRESH_US);
  }
  last[side] = pulse_us;
}

static void encoder_read(void *, int side, uint32_t *count, uint32_t *last_us) {
  noInterrupts();
  *count = edges[side];
  *last_us = edge_us[side];
  interrupts();
}

static bool range_poll(void *, struct hero_range *reading) {
  if (!ranger_ready || !ranger.dataReady()) return false;
  ranger.read(false);  // does not wait
  reading->distance_mm = ranger.ranging_data.range_mm;
  reading->valid = ranger.ranging_data.range_status == VL53L1X::RangeValid;
  return true;
}

// Takes some milliseconds, with the servos released or the robot in FAULT: at boot and after a time-out alone.
static void range_restart(void *) {
  digitalWrite(HERO_PIN_TOF_SHUTDOWN, LOW);
  delay(1);
  digitalWrite(HERO_PIN_TOF_SHUTDOWN, HIGH);
  delay(RANGE_WAKE_MS);
  ranger.setTimeout(20);
  ranger_ready = ranger.init();
  if (!ranger_ready) return;
  ranger.setDistanceMode(VL53L1X::Medium);
  ranger.setMeasurementTimingBudget(HERO_TOF_BUDGET_MS * 1000);
  ranger.setROISize(4, 4);
  ranger.startContinuous(HERO_TOF_PERIOD_MS);
}

static uint16_t battery_read(void *) {
  static uint32_t read_ms;
  static uint16_t millivolts;
  if (millivolts == 0 || millis() - read_ms >= BATTERY_PERIOD_MS) {
    read_ms = millis();
    millivolts = (uint32_t)analogRead(A0) * HERO_BATTERY_FULL_SCALE_MV / 1023;
  }
  return millivolts;
}

static void led_write(void *, bool on) { digitalWrite(HERO_PIN_STATUS_LED, on ? LOW : HIGH); }  // the module's LED is lit by LOW

static size_t receive(void *, uint8_t *data, size_t room, struct hero_peer *from) {
  int size = udp.parsePacket();
  if (size <= 0) return 0;
  from->address = (uint32_t)udp.remoteIP();
  from->port = udp.remotePort();
  int taken = udp.read(data, room);
  return (size_t)size > room ? room : (taken > 0 ? taken : 0);
}

static void send(void *, const uint8_t *data, size_t size, struct hero_peer to) {
  if (!udp.beginPacket(IPAddress(to.address), to.port)) return;
  udp.write(data, size);
  udp.endPacket();
}

static const struct hero_hal HAL = {nullptr, load_settings, random64, servo_write, encoder_read, range_poll,
                                    range_restart, battery_read, led_write, receive, send};

static void prepare_pins() {
  for (int side = 0; side < 2; side++) {
    digitalWrite(SERVO_PIN[side], LOW);
    pinMode(SERVO_PIN[side], OUTPUT);
    pinMode(ENCODER_PIN[side], INPUT_PULLUP);
  }
  pinMode(HERO_PIN_STATUS_LED, OUTPUT);
  pinMode(HERO_PIN_TOF_SHUTDOWN, OUTPUT);
  attachInterrupt(digitalPinToInterrupt(HERO_PIN_ENCODER_LEFT), left_edge, CHANGE);
  attachInterrupt(digitalPinToInterrupt(HERO_PIN_ENCODER_RIGHT), right_edge, CHANGE);
}

void setup() {
  prepare_pins();
  Wire.begin(HERO_PIN_TOF_SDA, HERO_PIN_TOF_SCL);
  Wire.setClock(400000);
  ranger.setBus(&Wire);
  WiFi.persistent(false);
  WiFi.mode(WIFI_STA);
  WiFi.setSleepMode(WIFI_NONE_SLEEP);  // a sleeping radio delays frames by a beacon, 100 ms
  WiFi.setAutoReconnect(true);
  WiFi.begin(HERO_WIFI_NAME, HERO_WIFI_PASSWORD);
  udp.begin(HERO_LINK_PORT);
  hero_robot_boot(&robot, &HAL, micros64());
}

void loop() { hero_robot_poll(&robot, micros64()); }
