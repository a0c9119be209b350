/*
 * What the belt asks of its motor.
 *
 * board.c answers on the chip, where steps are made by an interrupt; the tests answer on the host.
 */
#pragma once

#include <stdbool.h>
#include <stdint.h>

/* Begin to turn from rest. */
void drive_start(bool backward, uint16_t steps);

/* Stop after this many more steps, or as soon as deceleration allows. */
void drive_stop_after(uint16_t steps);

/* Stop at once: the motor does not turn as it is told. */
void drive_abort(void);

/* Whether it turns. */
bool drive_turning(void);
