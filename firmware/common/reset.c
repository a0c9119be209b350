#include "reset.h"

#include "protocol.h"

const char *reset_word(enum reset_cause cause) {
    static const char *const words[] = {
        [RESET_POWER] = PROTOCOL_RESET_POWER,       [RESET_BROWNOUT] = PROTOCOL_RESET_BROWNOUT,
        [RESET_EXTERNAL] = PROTOCOL_RESET_EXTERNAL, [RESET_WATCHDOG] = PROTOCOL_RESET_WATCHDOG,
        [RESET_SOFTWARE] = PROTOCOL_RESET_SOFTWARE, [RESET_PROGRAMMER] = PROTOCOL_RESET_PROGRAMMER,
    };
    return words[cause];
}
