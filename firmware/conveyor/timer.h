/* The timer that paces the steps. */
#pragma once

enum { STEP_TIMER_DIVIDER = 2 };
#define STEP_TIMER_HZ (F_CPU / STEP_TIMER_DIVIDER)
