/* What makes a program out of the common main loop: one board's pins and logic. */
#pragma once

#include <stdint.h>

#include "line.h"
#include "reset.h"
#include "session.h"

extern const struct identity board_identity;

/* Start pins and logic, with interrupts still off. */
void board_start(enum reset_cause cause);

/* Let a millisecond pass. */
void board_tick(void);

/* Carry out a command. The reply is empty if it comes later. */
void board_answer(const struct command *command, uint16_t damaged_lines, struct line *reply);

/* Do what can wait, while no line is being sent. The reply is mostly empty. */
void board_idle(struct line *reply);
