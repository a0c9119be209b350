/*
 * What the pure logic asks of the microcontroller it runs on.
 *
 * chip.c answers on the chip; the tests answer on the host.
 */
#pragma once

#include <stdbool.h>
#include <stdint.h>

/* A byte of the chip's own serial number, 0 to SERIAL_NUMBER_LENGTH - 1. */
uint8_t hardware_serial_number(uint8_t index);

/* Whether the fuses are what the image asks for. */
bool hardware_fuses_right(void);

/* Bytes between the variables and the deepest place that the stack has ever reached. */
uint16_t hardware_stack_left(void);

/* A byte of the EEPROM. */
uint8_t hardware_eeprom_read(uint8_t address);

/* Whether the last byte is written; it takes some milliseconds, in which the program goes on. */
bool hardware_eeprom_ready(void);

/* Begin to write a byte of the EEPROM, which must be ready. */
void hardware_eeprom_write(uint8_t address, uint8_t value);
