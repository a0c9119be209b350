/* The gripper's board without its pins: the latch, its calibration, and what the host may ask. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "calibration.h"
#include "debounce.h"
#include "latch.h"
#include "line.h"
#include "session.h"
#include "survivors.h"

/* What the pins say. */
struct gripper_inputs {
    uint16_t reference_reading; /* of the 1.1 V reference, in 1023ths of the supply */
    bool command_high;
    bool part;         /* the switch feels one */
    bool status_stuck; /* the status pin does not have the level that it is driven to */
};

struct gripper {
    struct latch latch;
    struct calibration calibration;
    struct gripper_inputs inputs;
    struct survivors *survivors;
    struct debounce part;
    struct debounce supply_low;
    struct session session;
    uint8_t store_left; /* bytes of the record that are still to be written */
    bool store_tried;   /* the next of them was written, and is to be looked at */
    bool keep_begun;    /* by the newest command */
    bool record_good;   /* there is a record in the EEPROM */
};

/* Start, with the calibration from the EEPROM; `survivors` is kept and updated. */
void gripper_start(struct gripper *gripper, struct survivors *survivors);

/* Let a millisecond pass. */
void gripper_tick(struct gripper *gripper, const struct gripper_inputs *inputs);

/*
 * Carry out a command. `damaged_lines` is what the reader of lines has counted.
 *
 * The reply is empty for a command to keep the calibration: gripper_store gives it later.
 */
void gripper_answer(struct gripper *gripper, const struct command *command, uint16_t damaged_lines,
                    struct line *reply);

/* Go on writing the EEPROM, if there is something to write. The reply is mostly empty. */
void gripper_store(struct gripper *gripper, struct line *reply);
