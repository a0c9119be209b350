/* How far and how long the servo turns, and the record of it in the EEPROM. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct calibration {
    uint16_t latch_pulse_us;
    uint16_t unlatch_pulse_us;
    uint16_t travel_ms;
};

enum { RECORD_LENGTH = 8 };

/* What holds before any calibration. */
extern const struct calibration calibration_default;

/* Whether a pulse, or a time of travel, is one that a servo may be given. */
bool calibration_pulse_valid(uint16_t pulse_us);
bool calibration_travel_valid(uint16_t travel_ms);

/* The byte of a record at an index. */
void calibration_encode(const struct calibration *calibration, uint8_t record[RECORD_LENGTH]);

/* Read a record; returns whether it is a whole one. If not, the calibration is the default. */
bool calibration_decode(struct calibration *calibration, const uint8_t record[RECORD_LENGTH]);
