#pragma once
struct TwoWire;
struct VL53L1X {
  enum DistanceMode { Short, Medium, Long, Unknown };
  enum RangeStatus : uint8_t { RangeValid = 0, SigmaFail = 1 };
  struct RangingData {
    uint16_t range_mm;
    RangeStatus range_status;
  };
  RangingData ranging_data;
  void setBus(TwoWire *);
  bool init(bool io_2v8 = true);
  void setTimeout(uint16_t);
  bool setDistanceMode(DistanceMode);
  bool setMeasurementTimingBudget(uint32_t);
  void setROISize(uint8_t, uint8_t);
  void startContinuous(uint32_t);
  bool dataReady();
  uint16_t read(bool blocking = true);
};
