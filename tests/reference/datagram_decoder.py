#!/usr/bin/env python3
"""An independent decoder of datagrams, written from docs/FORMAT.md alone; what they share with frames is context_decoder.py's.

Usage: datagram_decoder.py DATAGRAMS SENSOR PRIORS.rs STRIP_PRIORS.rs > returns
DATAGRAMS are datagrams, each behind its length as a little-endian u16, in any order. SENSOR is a text: checksum, ticks a turn,
clockwise (0 or 1), then each beam's azimuth phase in radians. Writes a line for every return: turn, column, tick, row, level.
Plain Python 3, nothing installed.
"""

import math
import re
import struct
import sys
import zlib

from context_decoder import Code, Strip, clamp


class Ticks:
    def __init__(self, code, rate):
        self.code, self.rate, self.beyond = code, rate, 0
        self.ones = {"other": [1311, 5243, 19661], "less": [57344, 8192], "far": [2048]}

    def decide(self, name, context):
        ones = self.ones[name]
        bit = self.code.decide(ones[context])
        ones[context] += 65535 - ones[context] >> 4 if bit else -(ones[context] >> 4)
        return bit

    def step(self):
        due = self.beyond + self.rate
        usual = clamp(due + 512 >> 10, 0, 65535)
        off = clamp(due - 1024 * usual, -512, 512)
        if not self.decide("other", 0 if abs(off) < 256 else 1 if abs(off) < 410 else 2):
            self.beyond = off
            return usual
        less = self.decide("less", int(off >= 0))
        distance = 1
        if self.decide("far", 0):
            n = self.code.raw(4)
            distance = 2**n + self.code.raw(n)
        self.beyond = 500 if less else -500
        return (usual - distance if less else usual + distance) % 65536


class Header:
    def __init__(self, datagram, sensor):
        (crc,) = struct.unpack("<I", datagram[-4:])
        assert crc == zlib.crc32(datagram[:-4] + struct.pack("<I", sensor.checksum)), "checksum"
        magic, self.kind, low, self.turn, self.first, self.columns, self.time, self.tick = struct.unpack_from(
            "<BBHHHHIH", datagram)
        assert magic == 0xF1 and low == sensor.checksum & 0xFFFF
        self.rest = datagram[16:-4]
        self.strip, self.rate, self.step = self.number(), self.number(), self.number()
        self.a_turn = self.number() if self.kind & 16 else 0
        self.noise, self.counts = self.bytes() if self.kind & 64 else (20, 1)
        self.id, self.stride = self.bytes() if self.kind & 128 else (0, 1)

    def number(self):
        number, place = 0, 0
        while True:
            byte, self.rest = self.rest[0], self.rest[1:]
            number |= (byte & 127) << place
            place += 7
            if byte < 128:
                return number

    def bytes(self):
        pair, self.rest = self.rest[:2], self.rest[2:]
        return pair


class Sensor:
    def __init__(self, text):
        checksum, ticks, clockwise, *phases = text.split()
        self.checksum, self.ticks = int(checksum), int(ticks)
        self.turn, self.phases = -1 if clockwise == "1" else 1, [float(phase) for phase in phases]

    def leads(self, columns):
        # Python rounds halves to even.
        return [round(self.turn * (phase / (2 * math.pi)) * columns) for phase in self.phases]


def decode(datagram, sensor, priors, strip_priors):
    header = Header(datagram, sensor)
    if header.columns == 0:
        assert header.kind & 32 and not header.rest
        return
    rows, tier, aligned = len(sensor.phases), header.kind & 3, header.kind >> 4 & 1
    leads = sensor.leads(header.a_turn)
    least, most = min(leads + [0]), max(leads + [0])
    before_first, before_others = (most - least, header.stride) if aligned else (0, 1)
    by_step = [8 * header.step <= header.noise, header.step <= header.noise, header.step <= 4 * header.noise, True]
    coarseness = by_step.index(True)
    first, others = strip_priors[aligned][coarseness]
    if tier == 3:
        code = Code(header.rest)
    else:
        prefix = struct.pack("<BBHH", header.kind & 15, header.noise, header.step, 65535)
        strip = Strip(prefix + header.rest, rows, header.columns, {0: first, 1: priors[1]})
        code = strip.code
    ticks, track = [header.tick], Ticks(code, header.rate)
    for column in range(header.columns):
        for _ in range(before_others if column else before_first):
            tick = ticks[-1] + track.step()
            tick -= sensor.ticks if tick >= sensor.ticks else 0
            assert tick < sensor.ticks
            ticks.append(tick)
        levels = [code.raw(16) for _ in range(rows)] if tier == 3 else strip.column()
        if column == 0 and tier != 3:
            for beam in strip.beams:
                beam.energy = (100 if coarseness == 0 else 16) if beam.level else beam.energy
            if tier == 0:
                strip.model.one = [256 * prior + 128 for prior in others]
        for row, level in enumerate(levels):
            if level:
                at = column * header.stride + most - leads[row] if aligned else column
                print(header.turn, header.first + column * header.stride, ticks[at], row, level)
    assert code.read - 3 == len(code.code), "the code is too long or too short"


def tables(path):
    return [[int(n) for n in re.findall(r"-?\d+", table)] for table in re.findall(r"= \[(.*?)\];", open(path).read(), re.S)]


def main():
    datagrams, sensor = open(sys.argv[1], "rb").read(), Sensor(open(sys.argv[2]).read())
    priors = tables(sys.argv[3])
    numbers = iter(tables(sys.argv[4])[0])
    strip_priors = [[[[next(numbers) for _ in range(len(priors[0]))] for _ in range(2)] for _ in range(4)] for _ in range(2)]
    at = 0
    while at < len(datagrams):
        (length,) = struct.unpack_from("<H", datagrams, at)
        decode(datagrams[at + 2:at + 2 + length], sensor, priors, strip_priors)
        at += 2 + length


if __name__ == "__main__":
    main()
