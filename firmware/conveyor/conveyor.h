/* The conveyor's board without its pins: the belt, and what the host may ask. */
#pragma once

#include "belt.h"
#include "line.h"
#include "session.h"

/* All zeros: at boot. */
struct conveyor {
    struct belt belt;
    struct session session;
    bool begun; /* the newest command is an index, and its outcome is the belt's */
};

/* Let a millisecond pass. */
void conveyor_tick(struct conveyor *conveyor, bool part, bool stall);

/* Carry out a command and write the reply. */
void conveyor_answer(struct conveyor *conveyor, const struct command *command, struct line *reply);
