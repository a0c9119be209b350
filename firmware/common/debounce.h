/* A level that counts only once it has stayed the same for a while. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct debounce {
    uint8_t count;    /* samples in a row that differ from `level`, or since the first one */
    bool level;       /* the level that counts */
    bool candidate;   /* until there is one: the level seen last */
    bool settled;     /* whether `level` means anything yet */
};

/*
 * Take a sample; `samples` in a row (at least 1) make a level count.
 *
 * Returns whether the level changed. The first one that settles is taken for granted: it is no
 * change.
 */
bool debounce_take(struct debounce *debounce, bool level, uint8_t samples);
