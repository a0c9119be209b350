/* The conveyor on an ATtiny1604: pins and the step timer. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "board.h"
#include "conveyor.h"
#include "drive.h"
#include "pins.h"
#include "timer.h"

enum { HOLD_MS = 100 }; /* current after the last step, until the rotor is still */

static uint8_t hold_left_ms;
static struct conveyor conveyor;
static struct ramp ramp; /* belongs to the step interrupt */

static void start_pins(void) {
    PORTA.OUTSET = ENABLE_bm; /* no current until there is something to turn */
    PORTA.DIRSET = STEP_bm | BACKWARD_bm | ENABLE_bm;
    PORTA.PART_CTRL = PORT_PULLUPEN_bm;
    PORTA.STALL_CTRL = PORT_PULLUPEN_bm;
    TCA0.SINGLE.INTCTRL = TCA_SINGLE_OVF_bm;
}

static void stop_timer(void) {
    TCA0.SINGLE.CTRLA = 0;
    TCA0.SINGLE.CNT = 0;
    TCA0.SINGLE.INTFLAGS = TCA_SINGLE_OVF_bm;
}

ISR(TCA0_OVF_vect) {
    TCA0.SINGLE.INTFLAGS = TCA_SINGLE_OVF_bm;
    PORTA.OUTSET = STEP_bm;
    ramp_step(&ramp);
    uint16_t interval = ramp_interval(&ramp);
    if (interval > 0) {
        TCA0.SINGLE.PER = interval - 1;
    } else {
        stop_timer();
    }
    PORTA.OUTCLR = STEP_bm; /* some microseconds high, as drivers ask for */
}

void drive_start(bool backward, uint16_t steps) {
    if (backward) {
        PORTA.OUTSET = BACKWARD_bm;
    } else {
        PORTA.OUTCLR = BACKWARD_bm;
    }
    PORTA.OUTCLR = ENABLE_bm;
    /* The first step comes after the longest interval: direction and current are long settled. */
    ramp_plan(&ramp, steps);
    TCA0.SINGLE.PER = ramp_interval(&ramp) - 1;
    TCA0.SINGLE.CTRLA = TCA_SINGLE_CLKSEL_DIV2_gc | TCA_SINGLE_ENABLE_bm;
}

void drive_stop_after(uint16_t steps) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        if (drive_turning()) {
            ramp_plan(&ramp, steps);
        }
    }
}

void drive_abort(void) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        stop_timer();
        ramp = (struct ramp){0};
    }
}

bool drive_turning(void) { return TCA0.SINGLE.CTRLA & TCA_SINGLE_ENABLE_bm; }

void board_tick(void) {
    uint8_t pins = PORTA.IN;
    conveyor_tick(&conveyor, !(pins & PART_bm), pins & STALL_bm);
    if (drive_turning()) {
        hold_left_ms = HOLD_MS;
    } else if (hold_left_ms > 0 && --hold_left_ms == 0) {
        PORTA.OUTSET = ENABLE_bm;
    }
}

void board_start(enum reset_cause cause) {
    (void)cause;
    start_pins();
    ramp_prepare();
}

void board_answer(const struct command *command, uint16_t damaged_lines, struct line *reply) {
    (void)damaged_lines;
    conveyor_answer(&conveyor, command, reply);
}

void board_idle(struct line *reply) { reply->length = 0; }
