/* The main loop of both boards: a tick's work, then the line's, then sleep. */
#include <avr/interrupt.h>

#include "board.h"
#include "chip.h"

static struct line_reader reader;
static struct line reply;

static void send_reply(void) {
    if (reply.length > 0) {
        chip_send(&reply);
    }
}

int main(void) {
    enum reset_cause cause = chip_start();
    board_start(cause);
    write_banner(&reply, &board_identity, reset_word(cause));
    sei();
    send_reply();
    for (;;) {
        if (chip_take_tick()) {
            board_tick();
            chip_prove_alive();
        }
        uint8_t byte;
        struct command command;
        while (chip_take_byte(&byte)) {
            if (line_read(&reader, byte, &command)) {
                board_answer(&command, reader.damaged, &reply);
                send_reply();
            }
        }
        if (!chip_sending()) {
            board_idle(&reply);
            send_reply();
        }
        chip_sleep();
    }
}
