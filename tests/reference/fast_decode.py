"""A decoder of the context coder's fast tier, written from docs/FORMAT.md alone.

    python3 fast_decode.py PRIORS PAYLOAD ROWS COLUMNS > LEVELS      (u16, low byte first, row-major)
"""
import struct
import sys


def main(priors_path, payload_path, rows, columns):
    priors, payload = open(priors_path, "rb").read(), open(payload_path, "rb").read()
    levels = levels_of(payload, int(rows), int(columns), priors)
    sys.stdout.buffer.write(struct.pack(f"<{len(levels)}H", *levels))


def levels_of(payload, rows, columns, priors):
    kind, noise, step, largest = struct.unpack("<BBHH", payload[:6])
    assert kind & 3 == 2 and kind & 4 == 0
    image = Image(priors, rows, columns, step, noise, largest)
    at, first = 6, 0
    while first < columns:
        (count,) = struct.unpack_from("<H", payload, at)
        if count == 0:
            count, body, at = columns - first, payload[at + 2 :], len(payload)
        else:
            (length,) = struct.unpack_from("<I", payload, at + 2)
            body, at = payload[at + 6 : at + 6 + length], at + 6 + length
        streams = Streams(body)
        for column in range(first, first + count):
            image.column(streams, column)
        streams.finish()
        first += count
    assert at == len(payload)
    return image.levels


class Streams:
    def __init__(self, body):
        self.body, self.words_end, self.bit = body, len(body) - 16, 0
        self.states = list(struct.unpack("<4I", body[-16:]))
        self.bits = int.from_bytes(body, "little")

    def symbol(self, state, frequencies):
        x = self.states[state]
        slot, start = x % 4096, 0
        for symbol, frequency in enumerate(frequencies):
            if slot < start + frequency:
                break
            start += frequency
        x = frequency * (x >> 12) + slot - start
        if x < 65536:
            self.words_end -= 2
            x = x << 16 | struct.unpack_from("<H", self.body, self.words_end)[0]
        self.states[state] = x
        return symbol

    def raw(self, count):
        value = self.bits >> self.bit & (1 << count) - 1
        self.bit += count
        return value

    def finish(self):
        assert self.raw(-self.bit % 8) == 0 and self.bit // 8 == self.words_end
        assert self.states == [65536] * 4


class Row:
    def __init__(self):
        self.predicted, self.energy, self.size, self.flip = 0, 64, 0, 0
        self.moved = self.negative = self.moved_before = self.negative_before = self.missed = 0


class Image:
    def __init__(self, priors, rows, columns, step, noise, largest):
        self.rows, self.columns, self.step, self.largest = rows, columns, step, largest
        self.levels = [0] * (rows * columns)
        self.all = [Row() for _ in range(-(-rows // 64) * 64)]
        self.sets = [0] * (len(self.all) // 8)
        self.changed = [[0, 0] for _ in range(len(self.all) // 64)]
        kind = 0 if step < 3 else 1 if step < 40 else 2 if step < 80 else 3
        self.cells = priors[17280 * kind : 17280 * (kind + 1)]
        self.symbols = [struct.unpack_from("<64H", priors, 69120 + 128 * t) for t in range(96)]
        self.nibbles = [struct.unpack_from("<16H", priors, 81408 + 32 * t) for t in range(80)]
        filtered = noise > 0 and step <= 3 * noise
        self.edge = max(2, noise // step) if filtered else 0
        self.gain = (11 if 4 * step <= 3 * noise else 14) if filtered else 16

    def column(self, streams, column):
        cells = [self.cell(row) for row in range(len(self.all))]
        for band in range(len(self.changed)):
            self.returns(streams, band)
            found = {}
            for group in range(8 * band, 8 * band + 8):
                self.group(streams, group, cells, found)
            above = 1
            for row in range(64 * band, 64 * band + 64):
                self.all[row].missed = int(row not in found)
                if row in found:
                    above = self.advance(self.all[row], *found[row], above)
                    self.levels[row * self.columns + column] = above

    def returns(self, streams, band):
        turn = 0

        def nibble(table):
            nonlocal turn
            turn += 1
            return streams.symbol((turn - 1) % 4, self.nibbles[table])

        for half in (0, 1):
            self.changed[band][half] = nibble(2 * self.changed[band][half] + half)
        for group in range(8):
            if self.changed[band][group // 4] >> group % 4 & 1:
                before = self.sets[8 * band + group]
                low = nibble(32 + 3 * (before % 16))
                high = nibble(32 + 3 * (before >> 4) + (2 if low == 0 else 1))
                self.sets[8 * band + group] = before ^ (low | high << 4)

    def cell(self, number):
        row, first = self.all[number], Row()
        north = self.all[number - 1] if number > 0 else first
        south = self.all[number + 1] if number + 1 < len(self.all) else first

        def turned(moved, negative):
            return moved + (moved & (negative ^ row.flip))

        def side(other):
            if self.step < 80:
                return turned(other.moved, other.negative)
            apart = abs(other.predicted - row.predicted) >= (self.step + 1) // 2
            apart = int(apart and other.predicted > 0 and row.predicted > 0)
            return turned(apart, int(apart and other.predicted < row.predicted))

        total = 3 * row.energy + north.energy + south.energy
        octave = max(total.bit_length() - 1, 0)
        half = total >> octave - 1 & 1 if octave else 0
        energy = min(max(2 * octave + half - 5, 0), 19)
        before = turned(row.moved_before, row.negative_before)
        place = min(3, 4 * number // self.rows)
        sides = 24 * side(south) + 8 * side(north)
        return 864 * energy + 216 * row.size + 72 * before + sides + 2 * place + row.missed

    def group(self, streams, group, cells, found):
        rows = [8 * group + n for n in range(8) if self.sets[group] >> n & 1]
        symbols = {row: streams.symbol(row % 4, self.symbols[self.cells[cells[row]]]) for row in rows}
        for row, symbol in symbols.items():
            kind = (symbol + 1) >> 1
            bits = (kind >> 1) - 1
            steps = kind if kind < 4 or symbol == 63 else ((2 + kind % 2) << bits) + streams.raw(bits)
            flip = self.all[row].flip
            found[row] = (steps, flip if symbol % 2 else 1 - flip)
        for row, symbol in symbols.items():
            if symbol == 63:
                found[row] = (streams.raw(16), streams.raw(1))

    def advance(self, row, steps, negative, above):
        predicted = row.predicted or above
        level = predicted + (-steps if negative else steps) * self.step
        level = min(max(level, 1), self.largest)
        filtered = predicted + ((level - predicted) * self.gain + 8 >> 4)
        row.predicted = level if steps > self.edge else filtered
        row.energy = (3 * row.energy + 16 * min(steps, 800)) >> 2
        row.size = min(steps, 3)
        row.moved_before, row.negative_before = row.moved, row.negative
        row.moved, row.negative = int(steps > 0), int(negative and steps > 0)
        if row.moved:
            row.flip = row.negative
        return level


if __name__ == "__main__":
    main(*sys.argv[1:])
