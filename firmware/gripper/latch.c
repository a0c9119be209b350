#include "latch.h"

#include "protocol.h"

static void begin(struct latch *latch, const struct calibration *calibration) {
    /* A new command is a new try: it leaves an old fault behind, and finds it again if it lasts. */
    latch->fault = PROTOCOL_FAULT_NONE;
    latch->confirmed = false;
    latch->pulse_us =
        calibration->numbers[latch->command.level ? UNLATCH_PULSE_US : LATCH_PULSE_US];
    latch->travel_left_ms = calibration->numbers[TRAVEL_MS];
}

static void end(struct latch *latch) {
    latch->travel_left_ms = 0;
    if (!latch->command.level) {
        latch->confirmed = true;
        latch->cycles++;
    }
}

void latch_tick(struct latch *latch, const struct calibration *calibration, bool command_high,
                bool supply_low) {
    if (++latch->toggle_ms == 2 * TOGGLE_HALF_PERIOD_MS) {
        latch->toggle_ms = 0;
    }
    if (debounce_take(&latch->command, command_high, COMMAND_SAMPLES)) {
        begin(latch, calibration);
    } else if (latch_moving(latch) && --latch->travel_left_ms == 0) {
        end(latch);
    }
    if (latch_moving(latch) && supply_low) {
        /* Nobody knows how far a starved servo came: it is let go, and nothing is confirmed. */
        latch->travel_left_ms = 0;
        latch->fault = PROTOCOL_FAULT_SUPPLY;
    }
}

bool latch_status(const struct latch *latch) {
    if (latch->fault != PROTOCOL_FAULT_NONE) {
        return latch->toggle_ms < TOGGLE_HALF_PERIOD_MS;
    }
    return latch->confirmed;
}
