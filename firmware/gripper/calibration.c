#include "calibration.h"

#include <stddef.h>

#include "crc8.h"
#include "noinline.h"

/* Neither 0x00 nor 0xFF, so that an erased EEPROM holds no calibration. */
enum { LAYOUT = 1 };

struct range {
    uint16_t min;
    uint16_t max;
    uint16_t usual;
};

static const struct range ranges[CALIBRATION_NUMBERS] = {
    [LATCH_PULSE_US] = {PROTOCOL_PULSE_MIN_US, PROTOCOL_PULSE_MAX_US, PROTOCOL_LATCH_PULSE_US},
    [UNLATCH_PULSE_US] = {PROTOCOL_PULSE_MIN_US, PROTOCOL_PULSE_MAX_US, PROTOCOL_UNLATCH_PULSE_US},
    [TRAVEL_MS] = {PROTOCOL_TRAVEL_MIN_MS, PROTOCOL_TRAVEL_MAX_MS, PROTOCOL_TRAVEL_MS},
};

NOINLINE bool calibration_in_range(uint8_t number, uint16_t value) {
    return value >= ranges[number].min && value <= ranges[number].max;
}

static uint8_t checksum(const struct calibration *calibration) {
    return crc8(calibration, offsetof(struct calibration, check));
}

void calibration_seal(struct calibration *calibration) {
    calibration->layout = LAYOUT;
    calibration->check = checksum(calibration);
}

bool calibration_recall(struct calibration *calibration) {
    bool whole = calibration->layout == LAYOUT && calibration->check == checksum(calibration);
    for (uint8_t number = 0; number < CALIBRATION_NUMBERS; number++) {
        whole = whole && calibration_in_range(number, calibration->numbers[number]);
    }
    for (uint8_t number = 0; !whole && number < CALIBRATION_NUMBERS; number++) {
        calibration->numbers[number] = ranges[number].usual;
    }
    return whole;
}
