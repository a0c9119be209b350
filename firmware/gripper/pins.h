/* The gripper's pins on an ATtiny412; drawn in docs/firmware.md. */
#pragma once

#include <avr/io.h>

/* PA0 is UPDI. */
#define COMMAND_bm PIN1_bm /* in: high asks for an open latch */
#define STATUS_bm PIN2_bm  /* out: high while a completed latch is confirmed */
#define SERVO_bm PIN3_bm   /* out: TCA0 WO0 */
#define PART_bm PIN7_bm    /* in, pulled up: low while the switch feels a part */
#define PART_CTRL PIN7CTRL

#define SERIAL_ONE_WIRE 1
#define SERIAL_PORT PORTA
#define SERIAL_TXD_CTRL PIN6CTRL
