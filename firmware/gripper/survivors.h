/* Counters in memory that outlive every reset but that of power-on. */
#pragma once

#include <stdint.h>

#include "reset.h"

struct survivors {
    uint16_t cycles; /* latches completed */
    uint16_t watchdog_resets;
    uint16_t brownout_resets;
    uint8_t check; /* CRC over the counters: a brown-out may have damaged them */
};

/* Count a start, from zero if the counters did not survive it. */
void survivors_start(struct survivors *survivors, enum reset_cause cause);

/* Set the number of cycles. */
void survivors_set_cycles(struct survivors *survivors, uint16_t cycles);
