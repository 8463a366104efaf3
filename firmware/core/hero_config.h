/* Constants of the robot file `hero_plus`: written by `python -m hero_robot.firmware.constants`, never by hand.
 * Q16.16: units of 1/65536. Q8.24: units of 2^-24. Binary angle: 2^32 is one turn. */
#ifndef HERO_CONFIG_H
#define HERO_CONFIG_H

#define HERO_CONTROL_PERIOD_US 20000 /* us, control_period */
#define HERO_MAX_SPEED 13107 /* m/s as Q16.16, max_linear_speed */
#define HERO_MAX_TURN 196608 /* rad/s as Q16.16, max_angular_speed */
#define HERO_WHEEL_BASE 4129 /* m as Q16.16, wheel_base */
#define HERO_WHEEL_BASE_INVERSE 1040254 /* 1/m as Q16.16, 1 / wheel_base */
#define HERO_MAX_RIM_SPEED 16880 /* m/s as Q16.16, servo_no_load_speed x wheel_diameter / 2 */
#define HERO_TICK_SPEED 105517301u /* rim speed, Q16.16 m/s, of one tick a us: pi wheel_diameter / encoder_ticks */
#define HERO_HALF_TICK 13506 /* m as Q8.24, rim path of half a tick */
#define HERO_HALF_TICK_TURN 8734805u /* binary angle, half the turn of one tick of one wheel */
#define HERO_VELOCITY_KP 1200 /* us of pulse for 1 m/s of error, velocity_kp */
#define HERO_VELOCITY_KI_STEP 46 /* us of pulse for 1 m/s of error in one control period, velocity_ki x control_period */
#define HERO_SERVO_US_PER_SPEED 951 /* us of pulse for 1 m/s, (servo_span_us - servo_deadband_us / 2) / MAX_RIM_SPEED */
#define HERO_ENCODER_STANDSTILL_US 250000u /* us, encoder_standstill */
#define HERO_ENCODER_REVERSAL_US 60000u /* us, encoder_reversal */
#define HERO_STALL_US 1000000u /* us, stall_time */
#define HERO_SERVO_HALT_US 1500 /* us, servo_halt_us */
#define HERO_SERVO_MIN_US 1000 /* us, servo_min_us */
#define HERO_SERVO_MAX_US 2000 /* us, servo_max_us */
#define HERO_SERVO_SPAN_US 250 /* us, servo_span_us */
#define HERO_SERVO_DEADBAND_US 10 /* us, servo_deadband_us */
#define HERO_SERVO_REFRESH_US 100000u /* us, servo_refresh */
#define HERO_SERVO_LAG_US 50000 /* us, servo_lag: of the simulated servo alone */
#define HERO_TOF_THRESHOLD_MM 1000 /* mm, range of the first sensor */
#define HERO_TOF_MIN_MM 40 /* mm, tof_min_range */
#define HERO_TOF_DEBOUNCE 2 /* readings, tof_debounce */
#define HERO_TOF_PERIOD_MS 50 /* ms, tof_period */
#define HERO_TOF_BUDGET_MS 33 /* ms, tof_timing_budget */
#define HERO_TOF_TIMEOUT_US 300000u /* us, tof_timeout */
#define HERO_BATTERY_NOMINAL_MV 3700 /* mV, battery_voltage */
#define HERO_BATTERY_WARNING_MV 3500 /* mV, battery_warning */
#define HERO_BATTERY_CUTOFF_MV 3300 /* mV, battery_cutoff */
#define HERO_BATTERY_FULL_SCALE_MV 5000 /* mV, battery_full_scale */
#define HERO_BATTERY_HOLD_OFF_US 2000000u /* us, battery_hold_off */
#define HERO_LINK_PORT 4210 /* UDP, link.port */
#define HERO_LEASE_MAX_US 500000u /* us, link.lease_max */
#define HERO_START_HORIZON_US 10000000u /* us, link.start_horizon */
#define HERO_STATUS_PERIOD_US 50000u /* us, link.status_period */
#define HERO_FRAMES_PER_POLL 6 /* frames, link.frames_per_poll */
#define HERO_PIN_TOF_SDA 4 /* GPIO, pins.tof_sda */
#define HERO_PIN_TOF_SCL 5 /* GPIO, pins.tof_scl */
#define HERO_PIN_TOF_SHUTDOWN 16 /* GPIO, pins.tof_shutdown */
#define HERO_PIN_ENCODER_LEFT 12 /* GPIO, pins.encoder_left */
#define HERO_PIN_ENCODER_RIGHT 13 /* GPIO, pins.encoder_right */
#define HERO_PIN_SERVO_LEFT 14 /* GPIO, pins.servo_left */
#define HERO_PIN_SERVO_RIGHT 15 /* GPIO, pins.servo_right */
#define HERO_PIN_STATUS_LED 2 /* GPIO, pins.status_led */

#endif
