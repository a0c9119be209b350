/* For a function that is smaller called than copied, which the compiler judges otherwise. */
#pragma once

#define NOINLINE __attribute__((noinline))
