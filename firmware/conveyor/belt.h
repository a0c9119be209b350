/* The belt: one index at a time, forward to the next part's edge, or one pitch backward. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "debounce.h"
#include "ramp.h"

enum {
    SENSOR_SAMPLES = 3, /* ms */
    STALL_SAMPLES = 3,
    /*
     * From the part's edge to rest. The sensor sees a part up to 4 mm before the stop; the rest
     * pays for slip and presses the part against the stop, where the belt slips under it. So
     * every index ends at the same place, and no error of one adds to the next.
     */
    SEAT_STEPS = 8 * STEPS_PER_MM,
};

enum outcome {
    INDEX_NONE,    /* there was none */
    INDEX_RUNNING, /* or about to begin, once the belt is at rest */
    INDEX_DONE,
    INDEX_NO_EDGE,
    INDEX_NO_MOTION,
    INDEX_SILENCE,
    INDEX_HALTED,
};

/* All zeros: at boot. */
struct belt {
    struct debounce sensor; /* level: sees a part */
    struct debounce stall;
    uint16_t steps;       /* how far the index may go */
    uint16_t indexes;     /* parts brought to the pick station; starts over after 65535 */
    uint8_t unheard_ms;   /* since the last valid line, while an index runs */
    enum outcome outcome; /* of the newest index */
    enum outcome latched; /* an error that must be cleared, or INDEX_NONE */
    bool backward;
    bool started;         /* the index that runs has begun to turn the motor */
    bool edge;            /* it has seen the part's edge */
    bool short_of_stop;   /* the part that the sensor sees: its index was cut off behind the edge */
};

/* Let a millisecond pass. */
void belt_tick(struct belt *belt, bool part, bool stall);

/* Begin an index; `pitch` is in PITCH_UNITs. No other may run, and nothing may be latched. */
void belt_index(struct belt *belt, bool backward, uint16_t pitch);

/* End the index that runs, if one does, and let the belt come to rest. */
void belt_halt(struct belt *belt);

/* The host was heard. */
static inline void belt_heard(struct belt *belt) { belt->unheard_ms = 0; }

static inline bool belt_running(const struct belt *belt) { return belt->outcome == INDEX_RUNNING; }
