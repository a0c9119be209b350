/* Why a program started. */
#pragma once

enum reset_cause {
    RESET_POWER,
    RESET_BROWNOUT,
    RESET_EXTERNAL,
    RESET_WATCHDOG,
    RESET_SOFTWARE,
    RESET_PROGRAMMER,
};

/* The word for it in the banner. */
const char *reset_word(enum reset_cause cause);
