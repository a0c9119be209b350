#include "line.h"

#include "crc8.h"

enum {
    SHORT_LENGTH = sizeof "1A S*00" - 1,
    LONG_LENGTH = sizeof "1A F 03E8*00" - 1,
};

/* Read hexadecimal digits; returns whether all of them are some, in capitals. */
static bool read_hex(const char *text, uint8_t digits, uint16_t *value) {
    uint16_t result = 0;
    for (; digits > 0; digits--) {
        uint8_t digit = (uint8_t)(*text++ - '0');
        if (digit > 9) {
            digit = (uint8_t)(digit - ('A' - '0' - 10));
            if (digit < 10 || digit > 15) {
                return false;
            }
        }
        result = (uint16_t)(result << 4 | digit);
    }
    *value = result;
    return true;
}

static bool parse(const char *text, uint8_t length, struct command *command) {
    uint16_t sequence = 0;
    uint16_t argument = 0;
    uint16_t checksum = 0;
    if (length != SHORT_LENGTH && length != LONG_LENGTH) {
        return false;
    }
    uint8_t body = (uint8_t)(length - 3);
    if (text[body] != '*' || !read_hex(text + body + 1, 2, &checksum) ||
        crc8(text, body) != checksum) {
        return false;
    }
    if (!read_hex(text, 2, &sequence) || text[2] != ' ' || text[3] < 'A' || text[3] > 'Z') {
        return false;
    }
    command->has_argument = length == LONG_LENGTH;
    if (command->has_argument && (text[4] != ' ' || !read_hex(text + 5, 4, &argument))) {
        return false;
    }
    command->sequence = (uint8_t)sequence;
    command->letter = text[3];
    command->argument = argument;
    return true;
}

bool line_read(struct line_reader *reader, uint8_t byte, struct command *command) {
    bool complete = reader->inside && byte == '\n';
    if (complete && parse(reader->text, reader->length, command)) {
        reader->inside = false;
        return true;
    }
    if (reader->inside && byte != '>' && !complete && reader->length < sizeof reader->text) {
        reader->text[reader->length++] = (char)byte;
        return false;
    }
    if (reader->inside) {
        reader->damaged++;
    }
    reader->inside = byte == '>';
    reader->length = 0;
    return false;
}

static void put(struct line *line, char byte) {
    /* The longest line is known to fit; a longer one is cut, and its reader drops it. */
    if (line->length < sizeof line->text) {
        line->text[line->length++] = byte;
    }
}

static void put_word(struct line *line, const char *word) {
    while (*word != '\0') {
        put(line, *word++);
    }
}

static void put_digit(struct line *line, uint8_t digit) {
    put(line, (char)(digit < 10 ? '0' + digit : 'A' - 10 + digit));
}

void line_digits(struct line *line, uint8_t value) {
    put_digit(line, value >> 4);
    put_digit(line, value & 0x0F);
}

void line_reply(struct line *line, uint8_t sequence, const char *kind) {
    line->length = 0;
    put(line, '<');
    line_digits(line, sequence);
    line_word(line, kind);
}

void line_banner(struct line *line, const char *role) {
    line->length = 0;
    put(line, '!');
    put_word(line, role);
}

void line_word(struct line *line, const char *word) {
    put(line, ' ');
    put_word(line, word);
}

void line_hex2(struct line *line, uint8_t value) {
    put(line, ' ');
    line_digits(line, value);
}

void line_hex4(struct line *line, uint16_t value) {
    line_hex2(line, (uint8_t)(value >> 8));
    line_digits(line, (uint8_t)value);
}

void line_end(struct line *line) {
    uint8_t checksum = crc8(line->text + 1, (uint8_t)(line->length - 1));
    put(line, '*');
    line_digits(line, checksum);
    put(line, '\n');
}
