/*
 * The gripper's logic on the host, one command a line on standard input.
 *
 * start CAUSE            switch it on (0 power ... 3 watchdog); EEPROM and survivors are kept
 * set NAME VALUE         command, part, stuck, reference; eeprom_stuck: writing changes nothing
 * poke ADDRESS VALUE     a byte of the EEPROM
 * tick COUNT             milliseconds; tells each change: "TIME_MS status S pulse P"
 * send HEX               bytes on the line
 *
 * What it sends is told as "sent TEXT"; every command ends with "done".
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "board.h"
#include "gripper.h"
#include "hardware.h"

static uint8_t eeprom[128];
static int eeprom_busy_ms;
static int eeprom_stuck;
static unsigned eeprom_writes;
static struct survivors survivors;
static struct gripper gripper;
static struct line_reader reader;
static struct line reply;
static struct gripper_inputs inputs;
static unsigned long now_ms;

uint8_t hardware_serial_number(uint8_t index) { return (uint8_t)(0xA0 + index); }
bool hardware_fuses_right(void) { return true; }
uint16_t hardware_stack_left(void) { return 99; }
uint8_t hardware_eeprom_read(uint8_t address) { return eeprom[address]; }
bool hardware_eeprom_ready(void) { return eeprom_busy_ms == 0; }

void hardware_eeprom_write(uint8_t address, uint8_t value) {
    if (!hardware_eeprom_ready()) {
        abort();
    }
    eeprom_busy_ms = 4;
    eeprom_writes++;
    if (!eeprom_stuck) {
        eeprom[address] = value;
    }
}

static void send_reply(void) {
    if (reply.length > 0) {
        printf("sent %.*s", reply.length, reply.text);
    }
}

static void start(int cause) {
    memset(&gripper, 0, sizeof gripper);
    memset(&reader, 0, sizeof reader);
    survivors_start(&survivors, (enum reset_cause)cause);
    gripper_start(&gripper, &survivors);
    write_banner(&reply, &board_identity, reset_word((enum reset_cause)cause));
    send_reply();
}

static void tick(unsigned count) {
    for (; count > 0; count--) {
        bool status = latch_status(&gripper.latch);
        bool moving = latch_moving(&gripper.latch);
        unsigned pulse = moving ? gripper.latch.pulse_us : 0;
        now_ms++;
        eeprom_busy_ms -= eeprom_busy_ms > 0;
        gripper_tick(&gripper, &inputs);
        unsigned new_pulse = latch_moving(&gripper.latch) ? gripper.latch.pulse_us : 0;
        if (status != latch_status(&gripper.latch) || pulse != new_pulse) {
            printf("%lu status %d pulse %u\n", now_ms, latch_status(&gripper.latch), new_pulse);
        }
        gripper_store(&gripper, &reply);
        send_reply();
    }
}

static void receive(const char *hex) {
    unsigned byte;
    struct command command;
    for (; sscanf(hex, "%2x", &byte) == 1; hex += 2) {
        if (line_read(&reader, (uint8_t)byte, &command)) {
            gripper_answer(&gripper, &command, reader.damaged, &reply);
            send_reply();
        }
    }
}

static void set(const char *name, int value) {
    if (strcmp(name, "command") == 0) {
        inputs.command_high = value != 0;
    } else if (strcmp(name, "part") == 0) {
        inputs.part = value != 0;
    } else if (strcmp(name, "stuck") == 0) {
        inputs.status_stuck = value != 0;
    } else if (strcmp(name, "reference") == 0) {
        inputs.reference_reading = (uint16_t)value;
    } else if (strcmp(name, "eeprom_stuck") == 0) {
        eeprom_stuck = value;
    } else {
        abort();
    }
}

int main(void) {
    static char text[1 << 20];
    char name[32];
    int first;
    int second;
    memset(eeprom, 0xFF, sizeof eeprom);
    while (fgets(text, sizeof text, stdin)) {
        if (sscanf(text, "start %d", &first) == 1) {
            start(first);
        } else if (sscanf(text, "set %31s %d", name, &first) == 2) {
            set(name, first);
        } else if (sscanf(text, "poke %d %d", &first, &second) == 2) {
            eeprom[first] = (uint8_t)second;
        } else if (sscanf(text, "tick %d", &first) == 1) {
            tick((unsigned)first);
        } else if (strncmp(text, "send ", 5) == 0) {
            receive(text + 5);
        } else if (strncmp(text, "writes", 6) == 0) {
            printf("writes %u\n", eeprom_writes);
        } else {
            return 2;
        }
        puts("done");
        fflush(stdout);
    }
    return 0;
}
