#include "conveyor.h"

#include "board.h"
#include "drive.h"

const struct identity board_identity = {
    .role = PROTOCOL_ROLE_CONVEYOR,
    .firmware = PROTOCOL_FIRMWARE_CONVEYOR,
};

void conveyor_tick(struct conveyor *conveyor, bool part, bool stall) {
    belt_tick(&conveyor->belt, part, stall);
}

static void reply_belt(const struct conveyor *conveyor, const struct command *command,
                       const char *kind, struct line *reply) {
    const struct belt *belt = &conveyor->belt;
    uint8_t flags = 0;
    if (belt->sensor.level) {
        flags |= PROTOCOL_CONVEYOR_FLAG_PART;
    }
    if (belt_running(belt) || drive_turning()) {
        flags |= PROTOCOL_CONVEYOR_FLAG_MOVING;
    }
    if (belt->latched != INDEX_NONE) {
        flags |= PROTOCOL_CONVEYOR_FLAG_LATCHED;
    }
    reply_status(reply, command, kind, flags, belt->indexes);
}

/* Tell how the newest index goes, or how it ended. */
static void reply_outcome(const struct conveyor *conveyor, const struct command *command,
                          struct line *reply) {
    static const char *const errors[] = {
        [INDEX_NO_EDGE] = PROTOCOL_ERROR_NO_EDGE,
        [INDEX_NO_MOTION] = PROTOCOL_ERROR_NO_MOTION,
        [INDEX_SILENCE] = PROTOCOL_ERROR_SILENCE,
        [INDEX_HALTED] = PROTOCOL_ERROR_HALTED,
    };
    enum outcome outcome = conveyor->belt.outcome;
    if (outcome == INDEX_RUNNING) {
        reply_belt(conveyor, command, PROTOCOL_REPLY_BUSY, reply);
    } else if (outcome == INDEX_DONE) {
        reply_belt(conveyor, command, PROTOCOL_REPLY_OK, reply);
    } else {
        reply_error(reply, command, errors[outcome]);
    }
}

static void answer_index(struct conveyor *conveyor, const struct command *command,
                         struct line *reply) {
    const char *refusal = 0;
    if (conveyor->begun) {
        reply_outcome(conveyor, command, reply);
        return;
    }
    if (!command->has_argument || command->argument < PROTOCOL_PITCH_MIN ||
        command->argument > PROTOCOL_PITCH_MAX) {
        refusal = PROTOCOL_ERROR_ARGUMENT;
    } else if (conveyor->belt.latched != INDEX_NONE) {
        refusal = PROTOCOL_ERROR_LATCHED;
    } else if (belt_running(&conveyor->belt)) {
        refusal = PROTOCOL_ERROR_MOVING;
    }
    if (refusal) {
        reply_error(reply, command, refusal);
        return;
    }
    belt_index(&conveyor->belt, command->letter == PROTOCOL_COMMAND_BACKWARD, command->argument);
    conveyor->begun = true;
    reply_outcome(conveyor, command, reply);
}

void conveyor_answer(struct conveyor *conveyor, const struct command *command, struct line *reply) {
    belt_heard(&conveyor->belt);
    enum verdict verdict = session_take(&conveyor->session, &board_identity, command, reply);
    if (verdict == COMMAND_IDENTIFIED) {
        belt_halt(&conveyor->belt);
    }
    if (verdict == COMMAND_NEW || verdict == COMMAND_IDENTIFIED) {
        conveyor->begun = false;
    }
    if (verdict == COMMAND_ANSWERED || verdict == COMMAND_IDENTIFIED) {
        return;
    }
    if (command->letter == PROTOCOL_COMMAND_FORWARD ||
        command->letter == PROTOCOL_COMMAND_BACKWARD) {
        answer_index(conveyor, command, reply);
        return;
    }
    if (command->has_argument) {
        reply_error(reply, command, PROTOCOL_ERROR_ARGUMENT);
        return;
    }
    switch (command->letter) {
    case PROTOCOL_COMMAND_STATUS:
        break;
    case PROTOCOL_COMMAND_HALT:
        belt_halt(&conveyor->belt);
        break;
    case PROTOCOL_COMMAND_CLEAR:
        conveyor->belt.latched = INDEX_NONE;
        break;
    default:
        reply_error(reply, command, PROTOCOL_ERROR_COMMAND);
        return;
    }
    reply_belt(conveyor, command, PROTOCOL_REPLY_OK, reply);
}
