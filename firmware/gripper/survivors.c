#include "survivors.h"

#include <stddef.h>
#include <string.h>

#include "crc8.h"

/* Of memory that is all zeros or all ones the check must not be right. */
enum { SALT = 0x5A };

static uint8_t checksum(const struct survivors *survivors) {
    return crc8(survivors, offsetof(struct survivors, check)) ^ SALT;
}

void survivors_start(struct survivors *survivors, enum reset_cause cause) {
    if (cause == RESET_POWER || survivors->check != checksum(survivors)) {
        memset(survivors, 0, sizeof *survivors);
    }
    if (cause == RESET_WATCHDOG) {
        survivors->watchdog_resets++;
    }
    if (cause == RESET_BROWNOUT) {
        survivors->brownout_resets++;
    }
    survivors->check = checksum(survivors);
}

void survivors_set_cycles(struct survivors *survivors, uint16_t cycles) {
    if (survivors->cycles != cycles) {
        survivors->cycles = cycles;
        survivors->check = checksum(survivors);
    }
}
