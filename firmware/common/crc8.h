/* The checksum of lines and of the record in the EEPROM. */
#pragma once

#include <stdint.h>

/* The CRC of `length` bytes: most significant bit first, not reflected, not inverted. */
uint8_t crc8(const void *data, uint8_t length);
