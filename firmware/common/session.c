#include "session.h"

#include "hardware.h"

static void reply_identity(struct line *reply, const struct command *command,
                           const struct identity *identity) {
    line_reply(reply, command->sequence, PROTOCOL_REPLY_OK);
    line_word(reply, identity->role);
    line_word(reply, "");
    for (uint8_t index = 0; index < SERIAL_NUMBER_LENGTH; index++) {
        line_digits(reply, hardware_serial_number(index));
    }
    line_hex2(reply, PROTOCOL_VERSION);
    line_word(reply, identity->firmware);
    line_end(reply);
}

enum verdict session_take(struct session *session, const struct identity *identity,
                          const struct command *command, struct line *reply) {
    if (command->letter == PROTOCOL_COMMAND_IDENTIFY && !command->has_argument) {
        session->identified = true;
        session->newest = command->sequence;
        reply_identity(reply, command, identity);
        return COMMAND_IDENTIFIED;
    }
    if (!session->identified) {
        reply_error(reply, command, PROTOCOL_ERROR_UNREADY);
        return COMMAND_ANSWERED;
    }
    if (command->sequence == session->newest) {
        return COMMAND_REPEATED;
    }
    if ((uint8_t)(session->newest - command->sequence) <= PROTOCOL_STALE_COUNT) {
        reply_error(reply, command, PROTOCOL_ERROR_STALE);
        return COMMAND_ANSWERED;
    }
    session->newest = command->sequence;
    return COMMAND_NEW;
}

void reply_error(struct line *reply, const struct command *command, const char *error) {
    line_reply(reply, command->sequence, PROTOCOL_REPLY_ERR);
    line_word(reply, error);
    line_end(reply);
}

void reply_status(struct line *reply, const struct command *command, const char *kind,
                  uint8_t flags, uint16_t value) {
    line_reply(reply, command->sequence, kind);
    line_hex2(reply, flags);
    line_hex4(reply, value);
    line_end(reply);
}

void write_banner(struct line *line, const struct identity *identity, const char *cause) {
    line_banner(line, identity->role);
    line_hex2(line, PROTOCOL_VERSION);
    line_word(line, cause);
    line_end(line);
}
