/* The conveyor's pins on an ATtiny1604; drawn in docs/firmware.md. */
#pragma once

#include <avr/io.h>

/* PA0 is UPDI. All of these are on port A. */
#define STEP_bm PIN1_bm     /* out: a rising edge is a step */
#define BACKWARD_bm PIN2_bm /* out: direction, high is backward */
#define ENABLE_bm PIN3_bm   /* out: low lets the motor have current; pulled up at the driver */
#define PART_bm PIN4_bm     /* in, pulled up: low while the sensor sees a part */
#define PART_CTRL PIN4CTRL
#define STALL_bm PIN5_bm /* in, pulled up: high while the driver reports a stall or is not there */
#define STALL_CTRL PIN5CTRL

#define SERIAL_ONE_WIRE 0
#define SERIAL_PORT PORTB
#define SERIAL_TXD_bm PIN2_bm
#define SERIAL_RXD_CTRL PIN3CTRL
