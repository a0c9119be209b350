#include "calibration.h"

#include "crc8.h"
#include "protocol.h"

/*
 * The record: its layout's version, three numbers with the low byte first, a CRC over all of it.
 * A version that is neither 0x00 nor 0xFF keeps an erased EEPROM from being a record.
 */
enum { RECORD_VERSION = 1 };

const struct calibration calibration_default = {
    .latch_pulse_us = PROTOCOL_LATCH_PULSE_US,
    .unlatch_pulse_us = PROTOCOL_UNLATCH_PULSE_US,
    .travel_ms = PROTOCOL_TRAVEL_MS,
};

bool calibration_pulse_valid(uint16_t pulse_us) {
    return pulse_us >= PROTOCOL_PULSE_MIN_US && pulse_us <= PROTOCOL_PULSE_MAX_US;
}

bool calibration_travel_valid(uint16_t travel_ms) {
    return travel_ms >= PROTOCOL_TRAVEL_MIN_MS && travel_ms <= PROTOCOL_TRAVEL_MAX_MS;
}

static void put(uint8_t *bytes, uint16_t value) {
    bytes[0] = (uint8_t)value;
    bytes[1] = (uint8_t)(value >> 8);
}

static uint16_t get(const uint8_t *bytes) { return (uint16_t)(bytes[1] << 8 | bytes[0]); }

void calibration_encode(const struct calibration *calibration, uint8_t record[RECORD_LENGTH]) {
    record[0] = RECORD_VERSION;
    put(record + 1, calibration->latch_pulse_us);
    put(record + 3, calibration->unlatch_pulse_us);
    put(record + 5, calibration->travel_ms);
    record[RECORD_LENGTH - 1] = crc8(record, RECORD_LENGTH - 1);
}

bool calibration_decode(struct calibration *calibration, const uint8_t record[RECORD_LENGTH]) {
    calibration->latch_pulse_us = get(record + 1);
    calibration->unlatch_pulse_us = get(record + 3);
    calibration->travel_ms = get(record + 5);
    if (record[0] == RECORD_VERSION &&
        record[RECORD_LENGTH - 1] == crc8(record, RECORD_LENGTH - 1) &&
        calibration_pulse_valid(calibration->latch_pulse_us) &&
        calibration_pulse_valid(calibration->unlatch_pulse_us) &&
        calibration_travel_valid(calibration->travel_ms)) {
        return true;
    }
    *calibration = calibration_default;
    return false;
}
