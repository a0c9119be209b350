#include "debounce.h"

bool debounce_take(struct debounce *debounce, bool level, uint8_t samples) {
    bool same = level == (debounce->settled ? debounce->level : !debounce->candidate);
    debounce->candidate = level;
    debounce->count = same ? 0 : (uint8_t)(debounce->count + 1);
    if (debounce->count < samples) {
        return false;
    }
    bool changed = debounce->settled;
    debounce->level = level;
    debounce->settled = true;
    debounce->count = 0;
    return changed;
}
