#!/usr/bin/env python3
"""An independent decoder of context-coded payloads, written from docs/FORMAT.md alone.

Usage: context_decoder.py FRAME PRIORS.rs [FAST_PRIORS.bin] > levels
Reads one frame, writes its levels row-major as little-endian u16. PRIORS.rs is src/coder/context/priors.rs, FAST_PRIORS.bin
fast/priors.bin beside it, whose numbers FORMAT.md takes to be part of the format; the second is for the fast tier alone. Plain Python 3, nothing installed.
"""

import math
import re
import struct
import sys

import fast_decode


def bits(x):
    return x.bit_length()


def sign(x):
    return (x > 0) - (x < 0)


def clamp(x, low, high):
    return low if x < low else high if x > high else x


def toward_zero(x, y):
    return x // y if x >= 0 else -(-x // y)


def half(x):
    return 2 * (bits(x) - 1) + (x >> (bits(x) - 2) & 1 if x > 1 else 0)


class Code:
    def __init__(self, code):
        self.code, self.read, self.range, self.offset = code, 0, 2**32 - 1, 0
        for _ in range(4):
            self.take()

    def take(self):
        byte = self.code[self.read] if self.read < len(self.code) else 0
        self.read += 1
        self.offset = (self.offset << 8 | byte) & 0xFFFFFFFF

    def renormalize(self):
        while self.range < 1 << 24:
            self.range <<= 8
            self.take()

    def decide(self, one):
        part = (self.range >> 16) * one
        bit = int(self.offset < part)
        if bit:
            self.range = part
        else:
            self.offset -= part
            self.range -= part
        self.renormalize()
        return bit

    def raw(self, n):
        self.range >>= n
        value = min(self.offset // self.range, (1 << n) - 1)
        self.offset -= value * self.range
        self.renormalize()
        return value


class Beam:
    def __init__(self):
        self.level = self.predicted = self.other = self.slope = self.size = self.sign = self.age = self.period = 0
        self.energy = 64


class Small:
    NAMES = [("same", 36), ("occupied", 32), ("active", 48), ("zero", 64), ("sign", 48), ("longer", 256), ("mantissa", 16)]
    flags = True

    def __init__(self, code, priors, strip):
        self.code, self.strip = code, strip
        self.at, at = {}, 0
        for name, contexts in self.NAMES:
            self.at[name] = at
            at += contexts
        assert at == len(priors)
        self.one = [256 * prior + 128 for prior in priors]

    def decide(self, name, context):
        at = self.at[name] + context
        bit = self.code.decide(self.one[at])
        if bit:
            self.one[at] += 65536 - self.one[at] >> 5
        else:
            self.one[at] -= self.one[at] >> 5
        return bit

    def same(self, s):
        return self.decide("same", s["class"])

    def occupied(self, s):
        return self.decide("occupied", s["W"] + 2 * s["N"] + 4 * s["WW"] + 8 * s["SW"] + 16 * s["changed"])

    def active(self, energy, north, below, above, _):
        context = min(3, energy // 4) * 12
        return self.decide("active", context + (north.size != 0) * 3 + (below.size != 0) * 6 + above)

    def residual(self, p, row, predicted, e, flag):
        s, own, north, south = self.strip, p[0], p[1], p[3]
        c = min(15, half(e + 1))
        guess = max(0, c // 2 - 3) if 4 * s.step <= s.noise else 0

        def zero():
            if flag == "due":
                return 1
            return self.decide("zero", c * 4 + (int(own.size == 0) if flag is None else 2 if flag == "seen" else 3))

        def longer(k):
            return self.decide("longer", c * 16 + k - 1)

        if guess < 2 and not zero():
            return 0
        length = max(1, guess)
        if longer(length):
            length += 1
            while longer(length) and length < 16:
                length += 1
        else:
            while length > 1 and not longer(length - 1):
                length -= 1
            if guess >= 2 and length == 1 and not zero():
                return 0
        side = 0 if south.level < predicted - 2 * s.step else 1 if south.level > predicted + 2 * s.step else 2
        negative = self.decide("sign", ((own.sign & 3) * 4 + (north.sign & 3)) * 3 + side)
        r = 1
        if length >= 2:
            r = 2 | self.decide("mantissa", length - 2)
            r = r << length - 2 | self.code.raw(length - 2)
        return -r if negative else r


class Dense:
    NAMES = [("same", [36, 64]), ("occupied", [32, 16, 16]), ("active", [12, 64, 36]), ("zero", [30, 64, 108, 108, 25, 64]),
             ("sign", [15, 36, 27, 6, 72]), ("exponent", [100, 56, 56, 56, 288]), ("mantissa", [48, 108, 60])]
    CLASS = [0, 1, 2, 3, 3, 4, 4, 5, 5, 5, 6, 6, 6, 6, 6, 7]

    def __init__(self, code, priors, strip):
        self.code, self.strip, self.flags = code, strip, strip.step >= strip.noise
        self.at, at = {}, 0
        for name, tables in self.NAMES:
            self.at[name] = []
            for contexts in tables:
                self.at[name].append(at)
                at += contexts
        assert at == len(priors)
        self.logit = [256 * prior for prior in priors]
        exact = (65536 / (1 + math.exp(-(i - 127.5) / 16)) for i in range(256))
        self.logistic = [clamp(math.floor(one + 0.5), 24, 65512) for one in exact]

    def decide(self, name, contexts):
        return self.decide_at(name, [table + context for table, context in zip(self.at[name], contexts, strict=True)])

    def decide_at(self, name, ats):
        x = sum(self.logit[at] for at in ats)
        one = self.logistic[clamp(x + 32768 >> 8, 0, 255)]
        bit = self.code.decide(one)
        step, noise = self.strip.step, self.strip.noise
        if 4 * step <= noise:
            rate = 64 if name in ("zero", "sign") else 128
        else:
            rate = 184 if 4 * step <= 3 * noise else 208 if step <= 3 * noise else 256
        for at in ats:
            self.logit[at] = clamp(self.logit[at] + ((65536 * bit - one) * rate >> 16), -32768, 32767)
        return bit

    def same(self, s):
        return self.decide("same", [s["class"], s["eighth"] * 8 + min(7, bits(s["energy"] // 8))])

    def occupied(self, s):
        return self.decide("occupied", [
            s["W"] + 2 * s["N"] + 4 * s["WW"] + 8 * s["SW"] + 16 * s["changed"],
            s["W"] + 2 * s["N2"] + 4 * s["NW"] + 8 * s["WWW"],
            min(7, bits(s["beam"].energy // 8)) * 2 + s["W"],
        ])

    def half_steps(self, v, predicted):
        return 2 * abs(v - predicted) * (65536 // self.strip.step) >> 16

    def side(self, v, predicted):
        h = self.half_steps(v, predicted)
        f = (h >= 2) + (h >= 12)
        return 2 - f if v < predicted else 3 + f

    def active(self, energy, north, below, above, rows):
        flag, ages, sides = self.at["active"]
        ats = [flag + (north.size != 0) * 3 + (below.size != 0) * 6 + above]
        for n, own, sw in rows:
            ats.append(ages + self.CLASS[own.age] * 8 + self.CLASS[own.period])
            ats.append(sides + self.side(n.level, own.predicted) * 6 + self.side(sw.level, own.predicted))
        return self.decide_at("active", ats)

    def residual(self, p, row, predicted, e, flag):
        own, n, n2, sw, sw2 = p

        def h(v):
            return self.half_steps(v, predicted)

        def side(v):
            return self.side(v, predicted)

        def s(x, m):
            return min(abs(x), m)

        quarter, energy = 4 * row // self.strip.rows, e if e < 4 else min(19, half(e))
        known = 0 if flag is None else 1 if flag == "seen" else 2
        if flag != "due" and not self.decide("zero", [
            energy // 2 * 3 + known,
            min(7, bits(h(n.level))) * 8 + min(7, bits(h(sw.level))),
            ((s(n2.size, 2) * 3 + s(own.size, 2)) * 3 + s(sw2.size, 2)) * 4 + quarter,
            (side(n.level) * 6 + side(sw.level)) * 3 + sign(own.size) + 1,
            s(n.size, 4) * 5 + s(own.size, 4),
            self.CLASS[own.age] * 8 + self.CLASS[own.period],
        ]):
            return 0
        negative = self.decide("sign", [
            (clamp(own.size, -2, 2) + 2) * 3 + sign(n.size) + 1,
            side(sw.level) * 6 + side(n.level),
            ((sign(sw.size) + 1) * 3 + sign(sw2.size) + 1) * 3 + sign(n2.size) + 1,
            side(own.other),
            ((own.sign + 1) * 3 + n.sign + 1) * 8 + min(7, own.age),
        ])

        def t(v):
            return h(v) // 2 if (v < predicted) == bool(negative) else 0

        def rel(t, k):
            return 0 if t == 0 else clamp(min(bits(t), 11) + 2 - min(k, 11), 1, 6)

        def more(k):
            few = min(k, 7)
            return self.decide("exponent", [
                energy // 2 * 10 + min(k, 9),
                rel(t(sw.level), k) * 8 + few,
                rel(t(n.level), k) * 8 + few,
                rel(t(own.other), k) * 8 + few,
                (s(n.size, 5) * 6 + s(own.size, 5)) * 8 + few,
            ])

        g = 0
        while g < 15 and more(g):
            g += 1
        r, left, node = 1, g, 0

        def b(v):
            other = t(v)
            if bits(other) != g + 1 or other >> left + 1 != r:
                return 2
            return other >> left & 1

        while left > 0:
            left -= 1
            sides = [b(own.other), b(n.level), b(sw.level)]
            if node == 3 and sides == [2, 2, 2]:
                left += 1
                break
            bit = self.decide("mantissa", [
                min(g, 11) * 4 + node,
                ((sides[0] * 3 + sides[1]) * 3 + sides[2]) * 4 + node,
                (energy // 4 * 3 + min(g, 2)) * 4 + node,
            ])
            r = r << 1 | bit
            node = 1 + bit if node == 0 else 3
        r = r << left | self.code.raw(left)
        return -r if negative else r


class Strip:
    def __init__(self, payload, rows, columns, priors):
        kind, self.noise, self.step, self.max_level = struct.unpack_from("<BBHH", payload)
        self.rows, self.columns = rows, columns
        self.median_edge = kind >> 2 & 1
        self.code = Code(payload[6:])
        tier = kind & 3
        self.model = (Small if tier == 0 else Dense)(self.code, priors[tier], self)
        self.groups = (rows + 7) // 8
        self.beams = [Beam() for _ in range(8 * self.groups)]
        self.sets = [[0] * rows for _ in range(3)]
        self.same_before = [0] * self.groups
        self.gain = 11 if 4 * self.step <= 3 * self.noise else 14 if self.step <= 3 * self.noise else 16
        self.edge = max(2, self.noise // self.step)

    def beam(self, row):
        return self.beams[row] if 0 <= row < len(self.beams) else Beam()

    def decode(self):
        columns = [self.column() for _ in range(self.columns)]
        assert self.code.read - 3 == len(self.code.code), "the code is too long or too short"
        return [column[row] for row in range(self.rows) for column in columns]

    def column(self):
        returns = self.returns()
        self.sets = [returns] + self.sets[:2]
        levels, self.last, above = [0] * self.rows, 0, 2
        self.north_west = None
        for first in range(0, self.rows, 4):
            above = self.quad(first, returns, levels, above)
        return levels

    def returns(self):
        w, ww, www = self.sets
        found, same_above = [0] * self.rows, 2

        def at(pixels, row):
            return pixels[row] if 0 <= row < self.rows else 0

        for group in range(self.groups):
            rows = range(8 * group, min(8 * group + 8, self.rows))
            last = [w[row] for row in rows]
            kind = 0 if not any(last) else 1 if sum(last) == 8 else 2
            same = self.model.same({
                "class": (kind * 4 + self.same_before[group]) * 3 + same_above,
                "eighth": 8 * group // self.groups,
                "energy": max(beam.energy for beam in self.beams[8 * group:8 * group + 8]),
            })
            changed = 0
            for row in rows:
                if same:
                    found[row] = w[row]
                elif row == rows[-1] and not changed:
                    found[row] = 1 - w[row]
                else:
                    found[row] = self.model.occupied({
                        "W": w[row], "WW": ww[row], "WWW": www[row], "N": at(found, row - 1), "N2": at(found, row - 2),
                        "NW": at(w, row - 1), "SW": at(w, row + 1), "changed": changed, "beam": self.beams[row],
                    })
                    changed |= found[row] != w[row]
            same_above = same
            self.same_before[group] = (self.same_before[group] << 1 | same) & 3
        return found

    def quad(self, first, returns, levels, above):
        rows = range(first, min(first + 4, self.rows))
        some = [row for row in rows if returns[row]]
        flag, said = None, 2
        if self.model.flags and len(some) >= 2 and not self.median_edge:
            beams = [self.beams[row] for row in some]
            energy = sum(beam.energy for beam in beams) // len(some)
            if energy < 14:
                said = self.model.active(energy, self.beam(first - 1), self.beam(first + 4), above,
                                         [[self.beam(at) for at in (row - 1, row, row + 1)] for row in some])
                flag = "open" if said else "calm"
        for row in rows:
            if not returns[row]:
                self.north_west = None
                continue
            if flag == "open" and row == some[-1]:
                flag = "due"
            r = self.pixel(row, flag, levels)
            if flag == "open" and r:
                flag = "seen"
        return said

    def pixel(self, row, flag, levels):
        own, north = self.beams[row], self.beam(row - 1)
        if own.level == 0:
            predicted = self.last or 1
        elif self.median_edge and self.north_west:
            w, n = own.level, north.level
            predicted = clamp(w + n - self.north_west, min(w, n), max(w, n))
        else:
            predicted = own.predicted
        r = 0
        if flag != "calm":
            around = [own, north, self.beam(row - 2), self.beam(row + 1), self.beam(row + 2)]
            e = (own.energy + around[3].energy) // 8
            r = self.model.residual(around, row, predicted, e, flag)
        level = clamp(predicted + r * self.step, 1, self.max_level)
        self.north_west, self.last, levels[row] = own.level, level, level
        self.remember(own, r, predicted, level)
        return r

    def remember(self, beam, r, p, v):
        if abs(r) > self.edge:
            if abs(r) > 4 * self.edge:
                beam.other, beam.slope = beam.level, 0
            beam.predicted = v
        else:
            d = v - p
            after = p + (d * self.gain + 8 >> 4)
            if 4 * self.step <= (3 if isinstance(self.model, Dense) else 1) * self.noise:
                beam.slope = clamp(beam.slope + toward_zero(d, 2), -127, 127)
                after += toward_zero(beam.slope - clamp(beam.slope, -self.step, self.step), 8)
            beam.predicted = clamp(after, 1, self.max_level)
        beam.level, beam.energy = v, (3 * beam.energy + 16 * min(abs(r), 1023)) // 4
        beam.size = bits(abs(r)) * sign(r)
        if r:
            beam.sign, beam.period, beam.age = sign(r), beam.age, 0
        else:
            beam.age = min(beam.age + 1, 15)


def main():
    frame = open(sys.argv[1], "rb").read()
    tables = re.findall(r"= \[(.*?)\];", open(sys.argv[2]).read(), re.S)
    fast_priors = open(sys.argv[3], "rb").read() if len(sys.argv) > 3 else None
    priors = [[int(number) for number in table.replace("\n", " ").split(",") if number.strip()] for table in tables]
    header_len, rows, columns = (struct.unpack_from("<H", frame, at)[0] for at in (6, 24, 26))
    assert frame[:5] == b"FLCR\x01" and frame[29] == 3, "no context-coded frame"
    image, at, next_column = [[] for _ in range(rows)], header_len, 0
    for _ in range(struct.unpack_from("<H", frame, 30)[0]):
        first, width, payload_len = struct.unpack_from("<HHI", frame, at)
        assert first == next_column and width > 0, "strips out of order"
        levels = levels_of(frame[at + 8:][:payload_len], frame[28], rows, width, priors, fast_priors)
        for row, line in enumerate(image):
            line += levels[row * width:][:width]
        at, next_column = at + 8 + payload_len, next_column + width
    assert next_column == columns and at + 4 == len(frame), "columns or bytes that no strip has"
    sys.stdout.buffer.write(b"".join(struct.pack(f"<{columns}H", *line) for line in image))


def levels_of(payload, level_bits, rows, columns, priors, fast_priors):
    if payload[0] & 3 == 2:
        return fast_decode.levels_of(payload, rows, columns, fast_priors)
    if payload[0] != 3:
        return Strip(payload, rows, columns, priors).decode()
    width = 1 if level_bits <= 8 else 2
    return [int.from_bytes(payload[at:at + width], "little") for at in range(1, len(payload), width)]


if __name__ == "__main__":
    main()
