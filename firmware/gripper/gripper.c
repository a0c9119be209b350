#include "gripper.h"

#include "board.h"
#include "hardware.h"
#include "noinline.h"

enum {
    PART_SAMPLES = 10,    /* the switch bounces for less, in ms */
    SUPPLY_SAMPLES = 20,  /* the servo's own dips are shorter, in ms */
    SUPPLY_MIN_MV = 4000, /* below it a servo of 5 V no longer turns the latch for certain */
    SUPPLY_MAX_MV = 5500,
    STACK_RESERVE = 16, /* bytes */
};

const struct identity board_identity = {
    .role = PROTOCOL_ROLE_GRIPPER,
    .firmware = PROTOCOL_FIRMWARE_GRIPPER,
};

void gripper_start(struct gripper *gripper, struct survivors *survivors) {
    gripper->survivors = survivors;
    gripper->latch.cycles = survivors->cycles;
    uint8_t *byte = (uint8_t *)&gripper->calibration;
    for (uint8_t index = 0; index < sizeof gripper->calibration; index++) {
        byte[index] = hardware_eeprom_read(index);
    }
    gripper->record_good = calibration_recall(&gripper->calibration);
}

/* The supply is 1.1 V * 1023 / reading, here without a 32-bit division. */
static NOINLINE uint16_t supply_mv(uint16_t reading) {
    const uint16_t part = 1100L * 1023 / 32;
    if (reading < 20) {
        return UINT16_MAX; /* no supply gives that */
    }
    return (uint16_t)(part / reading * 32 + part % reading * 32 / reading);
}

void gripper_tick(struct gripper *gripper, const struct gripper_inputs *inputs) {
    gripper->inputs = *inputs;
    debounce_take(&gripper->part, inputs->part, PART_SAMPLES);
    bool low = inputs->reference_reading > 1100L * 1023 / SUPPLY_MIN_MV;
    debounce_take(&gripper->supply_low, low, SUPPLY_SAMPLES);
    latch_tick(&gripper->latch, &gripper->calibration, inputs->command_high,
               gripper->supply_low.level);
    survivors_set_cycles(gripper->survivors, gripper->latch.cycles);
}

/* A mask if the condition holds, and nothing otherwise. */
static uint8_t bit(bool condition, uint8_t mask) { return condition ? mask : 0; }

static uint8_t flags(const struct gripper *gripper) {
    const struct latch *latch = &gripper->latch;
    return bit(gripper->part.level, PROTOCOL_GRIPPER_FLAG_PART) |
           bit(latch_moving(latch), PROTOCOL_GRIPPER_FLAG_MOVING) |
           bit(latch->fault != PROTOCOL_FAULT_NONE, PROTOCOL_GRIPPER_FLAG_LATCHED) |
           bit(latch->confirmed, PROTOCOL_GRIPPER_FLAG_CONFIRMED) |
           bit(latch->command.level, PROTOCOL_GRIPPER_FLAG_TOLD_OPEN) |
           bit(!gripper->record_good, PROTOCOL_GRIPPER_FLAG_DEFAULT);
}

static uint8_t self_test(const struct gripper *gripper) {
    uint16_t supply = supply_mv(gripper->inputs.reference_reading);
    return bit(!gripper->record_good, PROTOCOL_TEST_RECORD) |
           bit(supply < SUPPLY_MIN_MV || supply > SUPPLY_MAX_MV, PROTOCOL_TEST_SUPPLY) |
           bit(!hardware_fuses_right(), PROTOCOL_TEST_FUSES) |
           bit(hardware_stack_left() < STACK_RESERVE, PROTOCOL_TEST_STACK) |
           bit(gripper->inputs.status_stuck, PROTOCOL_TEST_STATUS_LINE) |
           bit(!gripper->part.settled, PROTOCOL_TEST_SENSOR);
}

static uint16_t read_register(const struct gripper *gripper, uint8_t number,
                              uint16_t damaged_lines) {
    if (number < CALIBRATION_NUMBERS) {
        return gripper->calibration.numbers[number];
    }
    switch (number) {
    case PROTOCOL_REGISTER_CYCLES:
        return gripper->latch.cycles;
    case PROTOCOL_REGISTER_WATCHDOG_RESETS:
        return gripper->survivors->watchdog_resets;
    case PROTOCOL_REGISTER_BROWNOUT_RESETS:
        return gripper->survivors->brownout_resets;
    case PROTOCOL_REGISTER_DAMAGED_LINES:
        return damaged_lines;
    case PROTOCOL_REGISTER_SUPPLY:
        return supply_mv(gripper->inputs.reference_reading);
    case PROTOCOL_REGISTER_FAULT:
        return gripper->latch.fault;
    default:
        return hardware_stack_left();
    }
}

static void reply_flags(const struct gripper *gripper, const struct command *command,
                        uint16_t value, struct line *reply) {
    reply_status(reply, command, PROTOCOL_REPLY_OK, flags(gripper), value);
}

/* Tell how keeping the calibration ended. */
static void reply_kept(const struct gripper *gripper, const struct command *command,
                       struct line *reply) {
    if (gripper->latch.fault == PROTOCOL_FAULT_STORE) {
        reply_error(reply, command, PROTOCOL_ERROR_LATCHED);
    } else {
        reply_flags(gripper, command, gripper->latch.cycles, reply);
    }
}

/* Begin to keep the calibration; the answer comes when that is done. */
static void answer_keep(struct gripper *gripper, const struct command *command,
                        struct line *reply) {
    if (!gripper->keep_begun) { /* a repetition begins nothing */
        if (latch_moving(&gripper->latch)) {
            reply_error(reply, command, PROTOCOL_ERROR_MOVING);
            return;
        }
        gripper->keep_begun = true;
        calibration_seal(&gripper->calibration);
        gripper->store_left = sizeof gripper->calibration;
    }
    if (gripper->store_left == 0) {
        reply_kept(gripper, command, reply);
    }
}

/* Change one number of the calibration, for the next time the latch moves. */
static void answer_calibrate(struct gripper *gripper, uint8_t number,
                             const struct command *command, struct line *reply) {
    if (!command->has_argument || !calibration_in_range(number, command->argument)) {
        reply_error(reply, command, PROTOCOL_ERROR_ARGUMENT);
    } else if (latch_moving(&gripper->latch) || gripper->store_left > 0) {
        reply_error(reply, command, PROTOCOL_ERROR_MOVING);
    } else {
        gripper->calibration.numbers[number] = command->argument;
        reply_flags(gripper, command, command->argument, reply);
    }
}

/* Write the calibration byte by byte, each looked at before and after: no wear, and no waiting. */
static void store(struct gripper *gripper) {
    uint8_t index = (uint8_t)(sizeof gripper->calibration - gripper->store_left);
    uint8_t wanted = ((const uint8_t *)&gripper->calibration)[index];
    if (hardware_eeprom_read(index) == wanted) {
        gripper->store_left--;
        gripper->store_tried = false;
        gripper->record_good = gripper->store_left == 0;
    } else if (gripper->store_tried) {
        gripper->store_left = 0;
        gripper->store_tried = false;
        gripper->record_good = false;
        gripper->latch.fault = PROTOCOL_FAULT_STORE;
    } else {
        hardware_eeprom_write(index, wanted);
        gripper->store_tried = true;
    }
}

void gripper_store(struct gripper *gripper, struct line *reply) {
    reply->length = 0;
    if (gripper->store_left == 0 || !hardware_eeprom_ready()) {
        return;
    }
    store(gripper);
    if (gripper->keep_begun && gripper->store_left == 0) {
        const struct command command = {.sequence = gripper->session.newest};
        reply_kept(gripper, &command, reply);
    }
}

void gripper_answer(struct gripper *gripper, const struct command *command, uint16_t damaged_lines,
                    struct line *reply) {
    reply->length = 0;
    enum verdict verdict = session_take(&gripper->session, &board_identity, command, reply);
    if (verdict == COMMAND_NEW || verdict == COMMAND_IDENTIFIED) {
        gripper->keep_begun = false;
    }
    if (verdict == COMMAND_ANSWERED || verdict == COMMAND_IDENTIFIED) {
        return;
    }
    uint16_t value = gripper->latch.cycles;
    bool wants_argument = false;
    bool known = true;
    switch (command->letter) {
    case PROTOCOL_COMMAND_LATCH_PULSE:
        answer_calibrate(gripper, LATCH_PULSE_US, command, reply);
        return;
    case PROTOCOL_COMMAND_UNLATCH_PULSE:
        answer_calibrate(gripper, UNLATCH_PULSE_US, command, reply);
        return;
    case PROTOCOL_COMMAND_TRAVEL:
        answer_calibrate(gripper, TRAVEL_MS, command, reply);
        return;
    case PROTOCOL_COMMAND_READ:
        wants_argument = command->argument <= PROTOCOL_REGISTER_STACK_LEFT;
        value = read_register(gripper, (uint8_t)command->argument, damaged_lines);
        break;
    case PROTOCOL_COMMAND_SELF_TEST:
        value = self_test(gripper);
        break;
    case PROTOCOL_COMMAND_CLEAR:
    case PROTOCOL_COMMAND_KEEP:
    case PROTOCOL_COMMAND_STATUS:
    case PROTOCOL_COMMAND_IDENTIFY:
        break;
    default:
        known = false;
    }
    if (command->has_argument != wants_argument) {
        reply_error(reply, command, PROTOCOL_ERROR_ARGUMENT);
    } else if (!known) {
        reply_error(reply, command, PROTOCOL_ERROR_COMMAND);
    } else if (command->letter == PROTOCOL_COMMAND_KEEP) {
        answer_keep(gripper, command, reply);
    } else {
        if (command->letter == PROTOCOL_COMMAND_CLEAR) {
            gripper->latch.fault = PROTOCOL_FAULT_NONE;
        }
        reply_flags(gripper, command, value, reply);
    }
}
