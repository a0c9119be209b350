/* How far and how long the servo turns, as it is kept in the EEPROM. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "protocol.h"

/* The numbers of a calibration, counted as the protocol's registers are. */
enum {
    LATCH_PULSE_US = PROTOCOL_REGISTER_LATCH_PULSE,
    UNLATCH_PULSE_US = PROTOCOL_REGISTER_UNLATCH_PULSE,
    TRAVEL_MS = PROTOCOL_REGISTER_TRAVEL,
    CALIBRATION_NUMBERS,
};

/* Byte for byte what the EEPROM holds, from its first byte on; numbers have the low byte first. */
struct calibration {
    uint16_t numbers[CALIBRATION_NUMBERS];
    uint8_t layout; /* version of this struct */
    uint8_t check;  /* CRC over all before it */
};

/* Whether a number is one that a servo may be given. */
bool calibration_in_range(uint8_t number, uint16_t value);

/* Make the check right, before the calibration is kept. */
void calibration_seal(struct calibration *calibration);

/* Whether this is a whole calibration. If not, it becomes the default. */
bool calibration_recall(struct calibration *calibration);
