"""What a serial line may carry: noise, pieces of the protocol, whole frames and damaged ones."""

from __future__ import annotations

import random
from typing import Final

from cellctl.boards.line import CommandLine, crc8, encode_command

LETTERS: Final = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def random_command(rng: random.Random) -> bytes:
    argument = rng.randrange(0x10000) if rng.random() < 0.5 else None
    return encode_command(CommandLine(rng.randrange(256), rng.choice(LETTERS), argument))


def sealed_nonsense(rng: random.Random) -> bytes:
    """A frame with the right checksum and nearly the right body."""
    body = bytearray(random_command(rng)[1:-4])
    body[rng.randrange(len(body))] = ord(rng.choice("09AFGaf @/:[*"))
    if rng.random() < 0.2:
        body += b"0"
    return b">%s*%02X\n" % (bytes(body), crc8(bytes(body)))


def garble(rng: random.Random, frame: bytes) -> bytes:
    """Damage a frame in one of the ways in which lines get damaged."""
    data = bytearray(frame)
    place = rng.randrange(len(data))
    match rng.randrange(6):
        case 0:
            data[place] ^= 1 << rng.randrange(8)
        case 1:
            del data[place]
        case 2:
            data.insert(place, rng.randrange(256))
        case 3:
            del data[place:]
        case 4:
            data[place] = ord(rng.choice("0123456789ABCDEFabcdef *>\n"))
        case _:
            data[place:place] = data[:place]
    return bytes(data)


def fuzz(seed: int, size: int) -> bytes:
    """Noise, digits and signs of the protocol, whole frames and damaged ones."""
    rng = random.Random(seed)  # noqa: S311 - repeatable chance
    stream = bytearray()
    while len(stream) < size:
        match rng.randrange(5):
            case 0:
                stream += rng.randbytes(rng.randrange(20))
            case 1:
                stream += bytes(rng.choices(b">0123456789ABCDEF *\n", k=rng.randrange(20)))
            case 2:
                stream += random_command(rng)
            case 3:
                stream += sealed_nonsense(rng)
            case _:
                stream += garble(rng, random_command(rng))
    return bytes(stream[:size])
