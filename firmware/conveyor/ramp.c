#include "ramp.h"

#include "timer.h"

/*
 * intervals[n] is the time between the steps n and n + 1 of an acceleration from rest. Step n comes
 * sqrt(2 n / a) after the start. The recurrence c(n) = c(n-1) - 2 c(n-1) / (4 n + 1) follows the
 * differences of that when its first value is 0.676 of the true one (D. Austin, "Generate
 * stepper-motor speed profiles in real time", 2005).
 */
static uint16_t intervals[RAMP_LEVELS];

void ramp_prepare(void) {
    const double steps_s2 = (double)ACCELERATION_MM_S2 * STEPS_PER_MM;
    uint32_t interval = (uint32_t)(256 * 0.676 * STEP_TIMER_HZ * __builtin_sqrt(2 / steps_s2));
    for (uint8_t level = 0; level < RAMP_LEVELS; level++) {
        if (level > 0) {
            interval -= 2 * interval / (4U * level + 1U);
        }
        intervals[level] = (uint16_t)(interval >> 8);
    }
}

void ramp_plan(struct ramp *ramp, uint16_t steps) {
    ramp->remaining = steps > ramp->level ? steps : ramp->level;
}

uint16_t ramp_interval(const struct ramp *ramp) {
    if (ramp->remaining == 0) {
        return 0;
    }
    return intervals[ramp->level > 0 ? ramp->level - 1 : 0];
}

void ramp_step(struct ramp *ramp) {
    if (ramp->remaining == 0) {
        return; /* told to stop before its first step: this one was the last */
    }
    ramp->remaining--;
    if (ramp->level > ramp->remaining) {
        ramp->level--;
    } else if (ramp->level < ramp->remaining && ramp->level < RAMP_LEVELS) {
        ramp->level++;
    }
}
