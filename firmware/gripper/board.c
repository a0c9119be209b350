/* The gripper on an ATtiny412: pins, servo timer and supply measurement. */
#include <avr/io.h>

#include "board.h"
#include "gripper.h"
#include "pins.h"

/* The servo's timer runs with a quarter of the clock: 0.4 us a count. */
static const uint16_t servo_frame_counts = F_CPU / 4 / 50; /* 20 ms */

static uint16_t servo_counts(uint16_t pulse_us) {
    return pulse_us * (uint16_t)(F_CPU / 2000000) / 2;
}

static struct survivors survivors __attribute__((section(".noinit")));
static struct gripper gripper;

static void start_pins(void) {
    /* Command and status have resistors to ground: a broken wire, and a reset, read as low. */
    PORTA.DIRSET = STATUS_bm | SERVO_bm;
    PORTA.PART_CTRL = PORT_PULLUPEN_bm;
    TCA0.SINGLE.PER = servo_frame_counts - 1;
    VREF.CTRLA = VREF_ADC0REFSEL_1V1_gc;
    VREF.CTRLB = VREF_ADC0REFEN_bm; /* always on: started anew it would not settle in time */
    ADC0.CTRLC = ADC_SAMPCAP_bm | ADC_REFSEL_VDDREF_gc | ADC_PRESC_DIV8_gc;
    ADC0.MUXPOS = ADC_MUXPOS_INTREF_gc;
    ADC0.CTRLA = ADC_ENABLE_bm;
    ADC0.COMMAND = ADC_STCONV_bm;
}

/* Give the servo pulses while the latch moves, and none otherwise. A pulse is never cut short. */
static void drive_servo(void) {
    bool running = TCA0.SINGLE.CTRLA & TCA_SINGLE_ENABLE_bm;
    uint16_t counts = servo_counts(gripper.latch.pulse_us);
    if (latch_moving(&gripper.latch)) {
        TCA0.SINGLE.CMP0BUF = counts;
        if (!running) {
            TCA0.SINGLE.CMP0 = counts;
            TCA0.SINGLE.CNT = 0;
            TCA0.SINGLE.CTRLB = TCA_SINGLE_CMP0EN_bm | TCA_SINGLE_WGMODE_SINGLESLOPE_gc;
            TCA0.SINGLE.CTRLA = TCA_SINGLE_CLKSEL_DIV4_gc | TCA_SINGLE_ENABLE_bm;
        }
    } else if (running && TCA0.SINGLE.CNT > TCA0.SINGLE.CMP0) {
        TCA0.SINGLE.CTRLA = 0;
        TCA0.SINGLE.CTRLB = 0;
    }
}

void board_tick(void) {
    uint8_t pins = PORTA.IN;
    bool told_high = PORTA.OUT & STATUS_bm;
    struct gripper_inputs inputs = {
        .reference_reading = ADC0.RES,
        .command_high = pins & COMMAND_bm,
        .part = !(pins & PART_bm),
        .status_stuck = told_high != (bool)(pins & STATUS_bm),
    };
    ADC0.COMMAND = ADC_STCONV_bm; /* ready long before the next tick */
    gripper_tick(&gripper, &inputs);
    if (latch_status(&gripper.latch)) {
        PORTA.OUTSET = STATUS_bm;
    } else {
        PORTA.OUTCLR = STATUS_bm;
    }
    drive_servo();
}

void board_start(enum reset_cause cause) {
    start_pins();
    survivors_start(&survivors, cause);
    gripper_start(&gripper, &survivors);
}

void board_answer(const struct command *command, uint16_t damaged_lines, struct line *reply) {
    gripper_answer(&gripper, command, damaged_lines, reply);
}

void board_idle(struct line *reply) { gripper_store(&gripper, reply); }
