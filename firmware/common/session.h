/* What is common to the conversations of both boards: who it is, and which lines are new. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line.h"

enum { SERIAL_NUMBER_LENGTH = 10 };

/* Who a board is. */
struct identity {
    const char *role;
    const char *firmware;
};

/* All zeros: no host has identified the board since its start. */
struct session {
    bool identified;
    uint8_t newest; /* sequence number of the newest command */
};

enum verdict {
    COMMAND_ANSWERED,   /* the reply is complete */
    COMMAND_NEW,        /* to be carried out */
    COMMAND_REPEATED,   /* to be carried out, or told again: it has the newest number */
    COMMAND_IDENTIFIED, /* the reply is complete, and a new session begins */
};

/* Decide what a command line is, and answer it where every board gives the same answer. */
enum verdict session_take(struct session *session, const struct identity *identity,
                          const struct command *command, struct line *reply);

/* Answer a command with an error. */
void reply_error(struct line *reply, const struct command *command, const char *error);

/* Answer a command with flags and a value; `kind` is ok or busy. */
void reply_status(struct line *reply, const struct command *command, const char *kind,
                  uint8_t flags, uint16_t value);

/* Write the banner of a board. */
void write_banner(struct line *line, const struct identity *identity, const char *cause);
