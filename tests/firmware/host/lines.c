/*
 * Two ways to try the reader of lines on the host.
 *
 * lines read                reads bytes from standard input and tells each command it finds
 * lines flip LONG LIMIT     flips one and two bits of frames and counts what is still taken
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "line.h"

static int read_all(void) {
    struct line_reader reader = {0};
    struct command command;
    int byte;
    while ((byte = getchar()) != EOF) {
        if (line_read(&reader, (uint8_t)byte, &command)) {
            printf("%u %c %d\n", command.sequence, command.letter,
                   command.has_argument ? command.argument : -1);
        }
    }
    printf("damaged %u\n", reader.damaged);
    return 0;
}

static size_t make_frame(char *frame, bool with_argument, uint32_t number) {
    struct line line;
    /* The writer of replies makes the body; only start character and fields differ. */
    char letter[] = {(char)('A' + number % 26), '\0'};
    line_reply(&line, (uint8_t)(number / 26), letter);
    if (with_argument) {
        line_hex4(&line, (uint16_t)(number * 40503u));
    }
    line_end(&line);
    memcpy(frame, line.text, line.length);
    frame[0] = '>';
    return line.length;
}

static bool taken(const char *frame, size_t length) {
    struct line_reader reader = {0};
    struct command command;
    bool found = false;
    for (size_t index = 0; index < length; index++) {
        found |= line_read(&reader, (uint8_t)frame[index], &command);
    }
    /* A frame that lost its end is ended by the next one's start. */
    found |= line_read(&reader, '>', &command);
    return found;
}

static int flip_all(bool with_argument, uint32_t frames) {
    uint64_t tried = 0;
    uint64_t missed = 0;
    bool checksums[256] = {false};
    for (uint32_t number = 0; number < frames; number++) {
        char frame[64];
        size_t length = make_frame(frame, with_argument, number);
        unsigned checksum = 0;
        if (!taken(frame, length) || sscanf(frame + length - 3, "%2X", &checksum) != 1) {
            return 1;
        }
        checksums[checksum] = true;
        for (size_t first = 0; first < 8 * length; first++) {
            frame[first / 8] = (char)(frame[first / 8] ^ 1 << first % 8);
            missed += taken(frame, length);
            tried++;
            for (size_t second = first + 1; second < 8 * length; second++) {
                frame[second / 8] = (char)(frame[second / 8] ^ 1 << second % 8);
                missed += taken(frame, length);
                tried++;
                frame[second / 8] = (char)(frame[second / 8] ^ 1 << second % 8);
            }
            frame[first / 8] = (char)(frame[first / 8] ^ 1 << first % 8);
        }
    }
    unsigned seen = 0;
    for (unsigned checksum = 0; checksum < 256; checksum++) {
        seen += checksums[checksum];
    }
    printf("tried %" PRIu64 " missed %" PRIu64 " checksums %u\n", tried, missed, seen);
    return 0;
}

int main(int count, char **arguments) {
    if (count == 2 && strcmp(arguments[1], "read") == 0) {
        return read_all();
    }
    if (count == 4 && strcmp(arguments[1], "flip") == 0) {
        return flip_all(atoi(arguments[2]) != 0, (uint32_t)strtoul(arguments[3], NULL, 10));
    }
    return 2;
}
