/*
 * The conveyor's logic on the host with a motor, one command a line on standard input.
 *
 * set NAME VALUE     edge: the sensor sees a part from this position on, in steps; stall
 * tick COUNT         milliseconds
 * send HEX           bytes on the line
 * state              "time T position P steps S shortest I peak V"
 *
 * Forward steps count up. What the board sends is told as "sent TEXT"; every command ends with
 * "done". The motor is watched: a step that comes sooner than the acceleration allows aborts.
 */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "conveyor.h"
#include "drive.h"
#include "timer.h"

enum { COUNTS_PER_MS = STEP_TIMER_HZ / 1000 };

static struct conveyor conveyor;
static struct line_reader reader;
static struct line reply;
static struct ramp ramp;
static bool turning;
static bool turning_back;
static long position;
static long edge = LONG_MAX;
static long steps;
static int stall;
static unsigned long now_ms;
static uint16_t shortest = UINT16_MAX;
static uint32_t counts_left; /* to the next step */
static bool hear_itself;

uint8_t hardware_serial_number(uint8_t index) { return index; }

void drive_start(bool backward, uint16_t count) {
    if (turning) {
        abort();
    }
    ramp_plan(&ramp, count);
    counts_left = ramp_interval(&ramp);
    turning = true;
    turning_back = backward;
}

void drive_stop_after(uint16_t count) {
    if (turning) {
        ramp_plan(&ramp, count);
    }
}

void drive_abort(void) {
    turning = false;
    ramp = (struct ramp){0};
}

bool drive_turning(void) { return turning; }

static void turn(uint32_t counts) {
    while (turning && counts >= counts_left) {
        counts -= counts_left;
        position += turning_back ? -1 : 1;
        steps++;
        ramp_step(&ramp);
        counts_left = ramp_interval(&ramp);
        if (counts_left == 0) {
            turning = false;
        } else if (counts_left < shortest) {
            shortest = (uint16_t)counts_left;
        }
    }
    counts_left -= turning ? counts : 0;
}

static void send_reply(void) { printf("sent %.*s", reply.length, reply.text); }

static void tick(unsigned count) {
    for (; count > 0; count--) {
        now_ms++;
        turn(COUNTS_PER_MS);
        conveyor_tick(&conveyor, position >= edge, stall);
        if (hear_itself) {
            belt_heard(&conveyor.belt);
        }
    }
}

static void receive(const char *hex) {
    unsigned byte;
    struct command command;
    for (; sscanf(hex, "%2x", &byte) == 1; hex += 2) {
        if (line_read(&reader, (uint8_t)byte, &command)) {
            conveyor_answer(&conveyor, &command, &reply);
            send_reply();
        }
    }
}

int main(void) {
    static char text[1 << 20];
    char name[32];
    long value;
    ramp_prepare();
    while (fgets(text, sizeof text, stdin)) {
        if (sscanf(text, "set %31s %ld", name, &value) == 2) {
            if (strcmp(name, "edge") == 0) {
                edge = value;
            } else if (strcmp(name, "stall") == 0) {
                stall = value != 0;
            } else if (strcmp(name, "heard") == 0) {
                hear_itself = value != 0;
            } else {
                return 2;
            }
        } else if (sscanf(text, "tick %ld", &value) == 1) {
            tick((unsigned)value);
        } else if (strncmp(text, "send ", 5) == 0) {
            receive(text + 5);
        } else if (strncmp(text, "state", 5) == 0) {
            printf("time %lu position %ld steps %ld shortest %u turning %d\n", now_ms, position,
                   steps, shortest, turning);
        } else {
            return 2;
        }
        puts("done");
        fflush(stdout);
    }
    return 0;
}
