#pragma once
int startWaveform(uint8_t, uint32_t, uint32_t, uint32_t run_us = 0);
int stopWaveform(uint8_t);
