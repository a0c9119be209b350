/*
 * The microcontroller as both programs use it: clock, tick, watchdog, serial line, sleep.
 *
 * Each program's pins.h says where the serial line is.
 */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line.h"
#include "reset.h"

/* Start clock, watchdog, tick and serial line, with interrupts still off. Returns the cause. */
enum reset_cause chip_start(void);

/* Take one of the milliseconds that have passed; returns whether there was one. */
bool chip_take_tick(void);

/* Prove that the tick's work is done. A quarter of a second without it, and the watchdog bites. */
void chip_prove_alive(void);

/* Sleep until something has happened; returns at once when there is something to do. */
void chip_sleep(void);

/* Take a received byte; there is none while a line is being sent. */
bool chip_take_byte(uint8_t *byte);

/* Send a line, which must stay as it is until the next byte can be taken. */
void chip_send(const struct line *line);

/* Whether a line is being sent. */
bool chip_sending(void);
