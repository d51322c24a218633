#!/usr/bin/env python3
"""An independent decoder of frames' planes, written from docs/FORMAT.md alone.

Usage: plane_decoder.py FRAME intensity|times > plane
Reads one frame whose levels are stored. Writes the intensities' numbers row-major, a byte each, 0 where there is no
return; or the columns' times, nanoseconds, as little-endian u64. Plain Python 3, nothing installed.
"""

import math
import struct
import sys

from context_decoder import Code, bits, clamp


def logistic(x):
    value = round(65536 / (1 + math.exp(-(clamp(x + 32768 >> 8, 0, 255) - 127.5) / 16)))
    return clamp(value, 24, 65512)


def side(value, middle):
    far = [d >= edge for d in (abs(value - middle),) for edge in (1, 2, 3, 5, 8, 13, 25)].count(True)
    return 7 - far if value < middle else 8 + far


class Beam:
    def __init__(self):
        self.last, self.seen, self.energy = [0, 0, 0], False, 80

    def take(self, value):
        if self.seen:
            self.energy = (7 * self.energy + 16 * min(63, abs(value - self.last[0]))) // 8
            self.last = [value] + self.last[:2]
        else:
            self.last, self.seen = [value] * 3, True


class Model:
    def __init__(self, code, rows, classes, max_steps):
        self.code, self.rows, self.classes, self.max = Code(code), rows, classes, max_steps
        self.logits, self.beams = {}, [Beam() for _ in range(rows)]

    def decide(self, contexts):
        x = sum(self.logits.get(context, 0) for context in contexts)
        one = logistic(x)
        bit = self.code.decide(one)
        by = (65536 * bit - one) >> 8
        for context in contexts:
            self.logits[context] = clamp(self.logits.get(context, 0) + by, -32768, 32767)
        return bit

    def steps(self, row):
        own = self.beams[row]
        beside = [self.beams[at] if 0 <= at < self.rows else Beam() for at in (row - 1, row + 1)]
        north, south_west = (beam.last[0] if beam.seen else own.last[0] for beam in beside)
        energy = min(7, bits(own.energy // 8))
        node, found, places = 1, 0, bits(self.max)
        for place in range(places):
            bit_value = 1 << places - 1 - place
            middle = found + bit_value
            one = 0
            if middle <= self.max:
                w, w2, w3 = (side(value, middle) for value in own.last)
                one = self.decide([
                    ("row", row * self.classes // self.rows, node),
                    ("west", node, w),
                    ("west2", node, w2),
                    ("wests", w, w2, place),
                    ("beside", side(north, middle), side(south_west, middle), place),
                    ("before", w, w3, energy),
                ])
            found += one * bit_value
            node = 2 * node + one
        own.take(found)
        return found


def sections(frame):
    header_len, strips = struct.unpack_from("<H", frame, 6)[0], struct.unpack_from("<H", frame, 30)[0]
    at, found = header_len, []
    for _ in range(strips):
        first, columns, length = struct.unpack_from("<HHI", frame, at)
        found.append((first, columns, frame[at + 8:at + 8 + length]))
        at += 8 + length
    bodies = {}
    while frame[5] & 2 and at < len(frame) - 4:
        kind, length = frame[at], struct.unpack_from("<I", frame, at + 4)[0]
        bodies[kind] = frame[at + 8:at + 8 + length]
        at += 8 + length
    assert at == len(frame) - 4, "a frame ends with its last section"
    return found, bodies


def parts(body, at, count):
    for _ in range(count):
        length = struct.unpack_from("<I", body, at)[0]
        yield body[at + 4:at + 4 + length]
        at += 4 + length
    assert at == len(body), "a section ends with its last part"


def intensities(strips, body, rows, columns, width):
    step, classes = body[0], body[1]
    image = bytearray(rows * columns)
    for (first, of_strip, payload), part in zip(strips, parts(body, 8, len(strips))):
        levels = [payload[at:at + width] for at in range(0, len(payload), width)]
        kind, max_steps, code = part[0], part[1], part[2:]
        model = Model(code, rows, classes, max_steps)
        stored = iter(code)
        for column in range(of_strip):
            for row in range(rows):
                if any(levels[row * of_strip + column]):
                    steps = next(stored) if kind == 1 else model.steps(row) if max_steps else 0
                    image[row * columns + first + column] = min(255, steps * step)
        if kind == 0 and max_steps:
            assert model.code.read - 3 == len(code), "a code ends where it should"
    return image


class Chance:
    def __init__(self, p=32768):
        self.p = p

    def bit(self, code):
        bit = code.decide(self.p)
        self.p += (65535 - self.p >> 5) if bit else -(self.p >> 5)
        return bit


class Number:
    def __init__(self):
        self.chances = [Chance() for _ in range(31)]

    def read(self, code):
        b = 0
        while b < 31 and self.chances[b].bit(code):
            b += 1
        low = min(b, 16)
        high_bits = code.raw(b - low)
        return (1 << b | high_bits << low | code.raw(low)) - 1


def times(strips, body, timestamp):
    unit = struct.unpack_from("<I", body)[0]
    for (_, columns, _), part in zip(strips, parts(body, 4, len(strips))):
        first, slope = struct.unpack_from("<qq", part)
        code, off, changes = Code(part[16:]), 0, [0, 0]
        is_change, less, number = [Chance(512), Chance(), Chance()], Chance(), Number()
        for column in range(columns):
            changed = is_change[sum(changes)].bit(code)
            changes = [changed, changes[0]]
            if changed:
                sign = -1 if less.bit(code) else 1
                off += sign * (number.read(code) + 1)
            yield (timestamp + unit * (first + (slope * column + 32768 >> 16) + off)) % 2**64
        assert code.read - 3 == len(part) - 16, "a code ends where it should"


def main():
    frame = open(sys.argv[1], "rb").read()
    rows, columns = (struct.unpack_from("<H", frame, at)[0] for at in (24, 26))
    assert frame[:5] == b"FLCR\x01" and frame[29] == 0, "no frame of stored levels"
    strips, bodies = sections(frame)
    if sys.argv[2] == "times":
        found = list(times(strips, bodies[2], struct.unpack_from("<Q", frame, 16)[0]))
        sys.stdout.buffer.write(struct.pack(f"<{len(found)}Q", *found))
    else:
        sys.stdout.buffer.write(intensities(strips, bodies[1], rows, columns, 1 if frame[28] <= 8 else 2))


if __name__ == "__main__":
    main()
