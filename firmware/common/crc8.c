#include "crc8.h"

#include <stdbool.h>

#include "protocol.h"

uint8_t crc8(const void *data, uint8_t length) {
    uint8_t crc = PROTOCOL_CRC_START;
    for (const uint8_t *byte = data; length > 0; length--) {
        crc ^= *byte++;
        for (uint8_t bit = 0; bit < 8; bit++) {
            bool carry = crc & 0x80;
            crc = (uint8_t)(crc << 1);
            if (carry) {
                crc ^= PROTOCOL_CRC_POLYNOMIAL;
            }
        }
    }
    return crc;
}
