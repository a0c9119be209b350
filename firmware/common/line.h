/*
 * Lines of the serial protocol: commands in, replies and banners out.
 *
 * Nothing here waits or touches hardware. The protocol is described in docs/serial-protocol.md.
 */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "protocol.h"

/* A valid command line. Whether there is such a letter is for the board to judge. */
struct command {
    uint16_t argument; /* meaningless without `has_argument` */
    uint8_t sequence;
    char letter;
    bool has_argument;
};

/* Puts bytes together to lines. All zeros: waiting for a line's start. */
struct line_reader {
    uint16_t damaged;             /* lines dropped, because damaged or cut short */
    uint8_t length;               /* of what is in `text` */
    bool inside;                  /* a line has started */
    char text[PROTOCOL_COMMAND_LIMIT - 2]; /* without start character and line feed */
};

/* Take a byte. Returns whether it completed a valid line, which is then in `command`. */
bool line_read(struct line_reader *reader, uint8_t byte, struct command *command);

/* A line to be sent. */
struct line {
    uint8_t length;
    char text[PROTOCOL_REPLY_LIMIT];
};

/* Begin a reply to the command with this sequence number; `kind` is ok, busy or err. */
void line_reply(struct line *line, uint8_t sequence, const char *kind);

/* Begin the banner of a board. */
void line_banner(struct line *line, const char *role);

/* Add a space and a field. */
void line_word(struct line *line, const char *word);
void line_hex2(struct line *line, uint8_t value);
void line_hex4(struct line *line, uint16_t value);

/* Add a number's digits without a space before them. */
void line_digits(struct line *line, uint8_t value);

/* Add checksum and end. */
void line_end(struct line *line);
