#include "chip.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

#include "hardware.h"
#include "noinline.h"
#include "pins.h"
#include "session.h"

#define BAUD_RATE 115200UL

enum {
    TICK_CYCLES = (int)(F_CPU / 1000),
    BAUD_REGISTER = (int)((64 * F_CPU / 16 + BAUD_RATE / 2) / BAUD_RATE),
    RING_SIZE = 16, /* a power of two; a command fits */
    PAINT = 0xC5,   /* what the stack has not touched */
};

enum {
    WATCHDOG_FUSE = WDT_PERIOD_256CLK_gc, /* on from the start, and locked by that */
    /* 2.6 V, always on: the servo's dips are ridden out, what 10 MHz cannot do is not. */
    BROWNOUT_FUSE = FUSE_LVL1_bm | FUSE_ACTIVE0_bm | FUSE_SLEEP0_bm,
    OSCILLATOR_FUSE = FUSE_FREQSEL1_bm, /* 20 MHz */
};

FUSES = {
    .WDTCFG = WATCHDOG_FUSE,
    .BODCFG = BROWNOUT_FUSE,
    .OSCCFG = OSCILLATOR_FUSE,
    /* No CRC scan, the first pin stays the programming pin, the EEPROM outlives a chip erase. */
    .SYSCFG0 = FUSE_CRCSRC_gm | FUSE_RSTPINCFG0_bm | FUSE_EESAVE_bm,
    .SYSCFG1 = FUSE_SUT_gm, /* 64 ms after power-on */
    .APPEND = 0,
    .BOOTEND = 0,
};

static volatile uint8_t ticks;
static volatile uint8_t ring[RING_SIZE];
static volatile uint8_t ring_in;
static volatile uint8_t ring_out;
static const char *volatile to_send;
static volatile uint8_t left_to_send; /* the byte on its way included */

/* Fill what lies between variables and stack, before anything uses the stack. */
extern uint8_t _end;
__attribute__((naked, used, section(".init3"))) static void paint_stack(void) {
    for (uint8_t *byte = &_end; byte <= (uint8_t *)RAMEND; byte++) {
        *byte = PAINT;
    }
}

static enum reset_cause read_cause(void) {
    /* A flag stays set until it is cleared. Power-on sets others too, so the order counts. */
    uint8_t flags = RSTCTRL.RSTFR;
    RSTCTRL.RSTFR = flags;
    uint8_t cause = RESET_POWER;
    while (cause < RESET_PROGRAMMER && !(flags & 1)) {
        flags >>= 1;
        cause++;
    }
    return (enum reset_cause)cause;
}

static void start_serial(void) {
#if SERIAL_ONE_WIRE
    /* Both directions on the TXD pin: driven low or let go, and heard by the own receiver. */
    SERIAL_PORT.SERIAL_TXD_CTRL = PORT_PULLUPEN_bm;
#else
    SERIAL_PORT.OUTSET = SERIAL_TXD_bm;
    SERIAL_PORT.DIRSET = SERIAL_TXD_bm;
    SERIAL_PORT.SERIAL_RXD_CTRL = PORT_PULLUPEN_bm;
#endif
    /* Corrected by the oscillator's error, which the factory measured at 5 V in 1024ths. */
    int8_t error = (int8_t)SIGROW.OSC20ERR5V;
    USART0.BAUD = (uint16_t)(BAUD_REGISTER + BAUD_REGISTER / 8 * error / 128);
    USART0.CTRLA = USART_RXCIE_bm | USART_TXCIE_bm | (SERIAL_ONE_WIRE ? USART_LBME_bm : 0);
    USART0.CTRLB = USART_RXEN_bm | USART_TXEN_bm | (SERIAL_ONE_WIRE ? USART_ODME_bm : 0);
}

enum reset_cause chip_start(void) {
    _PROTECTED_WRITE(CLKCTRL_MCLKCTRLB, CLKCTRL_PDIV_2X_gc | CLKCTRL_PEN_bm);
    /* The fuse does both already; a board whose fuses were not written is guarded all the same. */
    _PROTECTED_WRITE(WDT_CTRLA, WDT_PERIOD_256CLK_gc);
    _PROTECTED_WRITE(WDT_STATUS, WDT_LOCK_bm);
    enum reset_cause cause = read_cause();
    TCB0.CCMP = TICK_CYCLES - 1;
    TCB0.INTCTRL = TCB_CAPT_bm;
    TCB0.CTRLA = TCB_ENABLE_bm;
    start_serial();
    SLPCTRL.CTRLA = SLPCTRL_SMODE_IDLE_gc | SLPCTRL_SEN_bm;
    return cause;
}

/* An interrupt that nobody asked for: the program is no longer itself. The watchdog ends it. */
ISR(BADISR_vect, ISR_NAKED) {
    for (;;) {
    }
}

ISR(TCB0_INT_vect) {
    TCB0.INTFLAGS = TCB_CAPT_bm;
    ticks++;
}

bool chip_take_tick(void) {
    cli();
    bool due = ticks > 0;
    if (due) {
        ticks--;
    }
    sei();
    return due;
}

void chip_prove_alive(void) { wdt_reset(); }

ISR(USART0_RXC_vect) {
    uint8_t byte = USART0.RXDATAL;
    if (SERIAL_ONE_WIRE && left_to_send > 0) {
        return; /* the own echo */
    }
    /* A full ring loses the byte, and with it the line, which its checksum tells. */
    uint8_t next = (uint8_t)(ring_in + 1) % RING_SIZE;
    if (next != ring_out) {
        ring[ring_in] = byte;
        ring_in = next;
    }
}

ISR(USART0_TXC_vect) {
    USART0.STATUS = USART_TXCIF_bm;
    uint8_t left = left_to_send;
    if (left > 0) {
        left_to_send = --left;
    }
    if (left > 0) {
        const char *byte = to_send;
        USART0.TXDATAL = (uint8_t)*byte;
        to_send = byte + 1;
    }
}

static NOINLINE bool has_byte(void) { return left_to_send == 0 && ring_in != ring_out; }

bool chip_take_byte(uint8_t *byte) {
    if (!has_byte()) {
        return false;
    }
    *byte = ring[ring_out];
    ring_out = (uint8_t)(ring_out + 1) % RING_SIZE;
    return true;
}

NOINLINE void chip_send(const struct line *line) {
    to_send = line->text + 1;
    left_to_send = line->length;
    USART0.TXDATAL = (uint8_t)line->text[0];
}

bool chip_sending(void) { return left_to_send > 0; }

void chip_sleep(void) {
    cli();
    if (ticks == 0 && !has_byte()) {
        sei(); /* takes effect after the next instruction: nothing comes between */
        sleep_cpu();
    }
    sei();
}

uint8_t hardware_serial_number(uint8_t index) { return (&SIGROW.SERNUM0)[index]; }

bool hardware_fuses_right(void) {
    return FUSE.WDTCFG == WATCHDOG_FUSE && FUSE.BODCFG == BROWNOUT_FUSE &&
           FUSE.OSCCFG == OSCILLATOR_FUSE;
}

NOINLINE uint16_t hardware_stack_left(void) {
    /* The stack is not empty here, so the search ends. */
    uint16_t left = 0;
    while ((&_end)[left] == PAINT) {
        left++;
    }
    return left;
}

uint8_t hardware_eeprom_read(uint8_t address) {
    return *(const volatile uint8_t *)(MAPPED_EEPROM_START + address);
}

bool hardware_eeprom_ready(void) { return !(NVMCTRL.STATUS & NVMCTRL_EEBUSY_bm); }

void hardware_eeprom_write(uint8_t address, uint8_t value) {
    *(volatile uint8_t *)(MAPPED_EEPROM_START + address) = value;
    _PROTECTED_WRITE_SPM(NVMCTRL_CTRLA, NVMCTRL_CMD_PAGEERASEWRITE_gc);
}
