/*
 * A trapezoidal ramp of single steps: when the next one is due.
 *
 * Speed is a level: on level n the motor has made n steps of its acceleration, so that it needs n
 * more to stop. Therefore a ramp ends exactly where it is planned to, whatever happens on its way.
 */
#pragma once

#include <stdbool.h>
#include <stdint.h>

enum {
    STEPS_PER_MM = 40,
    SPEED_MM_S = 100,
    ACCELERATION_MM_S2 = 2500,
    /* v^2 / 2a: steps from rest to full speed. */
    RAMP_LEVELS = SPEED_MM_S * SPEED_MM_S / (2 * (ACCELERATION_MM_S2 / STEPS_PER_MM)),
};

/* All zeros: at rest. */
struct ramp {
    uint16_t remaining; /* steps to go; at least `level` */
    uint8_t level;
};

/* Compute the times between steps, once before any ramp. */
void ramp_prepare(void);

/*
 * Plan to stop after this many steps, or as soon as deceleration allows. A first step that is under
 * way already is made all the same.
 */
void ramp_plan(struct ramp *ramp, uint16_t steps);

/* Timer counts until the next step is due; 0 at rest. To be asked after ramp_plan from rest. */
uint16_t ramp_interval(const struct ramp *ramp);

/* Note that a step was made. */
void ramp_step(struct ramp *ramp);
