#include "belt.h"

#include "drive.h"
#include "protocol.h"

enum { STEPS_PER_PITCH_UNIT = STEPS_PER_MM * (int)PROTOCOL_PITCH_UNIT_UM / 1000 };

_Static_assert(STEPS_PER_PITCH_UNIT * 1000L == STEPS_PER_MM * (long)PROTOCOL_PITCH_UNIT_UM,
               "a pitch is a whole number of steps, or errors would add up");
_Static_assert(1UL * STEPS_PER_PITCH_UNIT * PROTOCOL_PITCH_MAX *
                       PROTOCOL_TRAVEL_LIMIT_PITCHES_PERCENT / 100 <= UINT16_MAX,
               "the longest index fits");

static void end(struct belt *belt, enum outcome outcome) {
    belt->outcome = outcome;
    belt->short_of_stop = !belt->backward && belt->edge && outcome != INDEX_DONE;
    if (outcome == INDEX_NO_EDGE || outcome == INDEX_NO_MOTION) {
        belt->latched = outcome;
    }
}

void belt_index(struct belt *belt, bool backward, uint16_t pitch) {
    uint16_t steps = (uint16_t)(pitch * STEPS_PER_PITCH_UNIT);
    belt->backward = backward;
    belt->started = false;
    belt->edge = false;
    belt->unheard_ms = 0;
    if (backward) {
        belt->steps = steps;
    } else {
        belt->steps = (uint16_t)((uint32_t)steps * PROTOCOL_TRAVEL_LIMIT_PITCHES_PERCENT / 100);
    }
    bool done = !backward && belt->sensor.level && !belt->short_of_stop;
    belt->outcome = done ? INDEX_DONE : INDEX_RUNNING;
}

void belt_halt(struct belt *belt) {
    if (belt_running(belt)) {
        drive_stop_after(0);
        end(belt, INDEX_HALTED);
    }
}

/* The motor has come to rest by itself. */
static void arrive(struct belt *belt) {
    if (belt->backward) {
        end(belt, belt->sensor.level ? INDEX_NO_MOTION : INDEX_DONE);
    } else if (belt->edge) {
        belt->indexes++;
        end(belt, INDEX_DONE);
    } else {
        end(belt, INDEX_NO_EDGE);
    }
}

static void run(struct belt *belt) {
    belt->unheard_ms++;
    if (belt->unheard_ms >= PROTOCOL_SILENCE_MS) {
        drive_stop_after(0);
        end(belt, INDEX_SILENCE);
    } else if (!belt->started) {
        if (!drive_turning()) {
            drive_start(belt->backward, belt->steps);
            belt->started = true;
        }
    } else if (belt->stall.level) {
        drive_abort();
        end(belt, INDEX_NO_MOTION);
    } else if (!belt->backward && !belt->edge && belt->sensor.level) {
        drive_stop_after(SEAT_STEPS);
        belt->edge = true;
    } else if (!drive_turning()) {
        arrive(belt);
    }
}

void belt_tick(struct belt *belt, bool part, bool stall) {
    debounce_take(&belt->sensor, part, SENSOR_SAMPLES);
    debounce_take(&belt->stall, stall, STALL_SAMPLES);
    if (!belt->sensor.level) {
        belt->short_of_stop = false;
    }
    if (belt_running(belt)) {
        run(belt);
    }
}
