/*
 * The latch: a servo that turns when the command line changes, and a status line that tells of it.
 *
 * The line's level at boot is taken for granted and moves nothing. Every later change begins a
 * travel, also in the middle of another one. At its end the servo is let go: the latch holds by
 * itself.
 */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "calibration.h"
#include "debounce.h"

enum {
    COMMAND_SAMPLES = 6,         /* in ms: a shorter glitch of the command line moves nothing */
    TOGGLE_HALF_PERIOD_MS = 100, /* of the status line while a fault is latched */
};

/* All zeros: at boot. */
struct latch {
    struct debounce command; /* level: the robot asks for an open latch */
    uint16_t travel_left_ms; /* 0: at rest */
    uint16_t pulse_us;       /* towards which the servo turns while it travels */
    uint16_t cycles;         /* latches completed; starts over after 65535 */
    uint8_t fault;           /* FAULT_..., latched */
    uint8_t toggle_ms;
    bool confirmed;          /* a latch was completed, and nothing was commanded since */
};

/* Let a millisecond pass. */
void latch_tick(struct latch *latch, const struct calibration *calibration, bool command_high,
                bool supply_low);

/* The level of the status line. */
bool latch_status(const struct latch *latch);

static inline bool latch_moving(const struct latch *latch) { return latch->travel_left_ms > 0; }
