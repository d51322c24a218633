"""Reader of TensorFlow checkpoints ("tensor bundles"), so that TensorFlow need not be installed.

NAME.index is a LevelDB table: blocks of keys that share prefixes, each followed by a compression byte and a masked CRC-32C, then
a footer with the place of the index block. Its values are protocol buffers (BundleHeaderProto under the empty key,
BundleEntryProto under a tensor's name); NAME.data-00000-of-00001 holds the tensors, little endian, at the entries' offsets.
"""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

FOOTER_LEN = 48
BLOCK_TRAILER_LEN = 5
TABLE_MAGIC = 0xDB4775248B80FB57
DTYPES = {1: np.dtype("<f4"), 2: np.dtype("<f8"), 3: np.dtype("<i4"), 9: np.dtype("<i8")}


class CheckpointError(ValueError):
    """The files are not a checkpoint of the kind that is read here."""


@dataclass(frozen=True)
class Entry:
    """Where a tensor lies in the data file, and what it is."""

    dtype: np.dtype
    shape: tuple
    offset: int
    length: int
    masked_crc: int


def read_checkpoint(prefix):
    """The tensors of the checkpoint whose files start with `prefix`, by name. Those of training (slots, step) are among them."""
    index_path, data_path = Path(f"{prefix}.index"), Path(f"{prefix}.data-00000-of-00001")
    data = data_path.read_bytes()
    tensors = {}
    for name, entry in read_index(index_path.read_bytes()).items():
        raw = data[entry.offset : entry.offset + entry.length]
        expected = int(np.prod(entry.shape, dtype=np.int64)) * entry.dtype.itemsize
        if len(raw) != expected:
            raise CheckpointError(f"{data_path.name}: {name} has {len(raw)} bytes, expected {expected}")
        _check_crc(raw, entry.masked_crc, f"{data_path.name}: {name}")
        tensors[name] = np.frombuffer(raw, entry.dtype).reshape(entry.shape)
    return tensors


def read_index(table):
    """The entries of an index file by tensor name."""
    if len(table) < FOOTER_LEN:
        raise CheckpointError(f"index of {len(table)} bytes, expected at least {FOOTER_LEN}")
    footer = table[-FOOTER_LEN:]
    (magic,) = struct.unpack("<Q", footer[-8:])
    if magic != TABLE_MAGIC:
        raise CheckpointError(f"index ends in {magic:#x}, expected {TABLE_MAGIC:#x}")
    _, _, position = _handle(footer, 0)
    index_offset, index_length, _ = _handle(footer, position)
    entries = {}
    for _, handle in _block(table, index_offset, index_length):
        offset, length, _ = _handle(handle, 0)
        for key, value in _block(table, offset, length):
            if key == b"":
                _check_header(value)
            else:
                entries[key.decode()] = _entry(value)
    return entries


def _block(table, offset, length):
    """Keys and values of a block: shared prefix length, own length, value length, key's rest, value; restart points at the end."""
    block = table[offset : offset + length]
    trailer = table[offset + length : offset + length + BLOCK_TRAILER_LEN]
    if len(block) < 4 or len(trailer) < BLOCK_TRAILER_LEN:
        raise CheckpointError(f"index ends inside the block at {offset}")
    kind, masked_crc = struct.unpack("<BI", trailer)
    if kind != 0:
        raise CheckpointError(f"block at {offset} is compressed ({kind}), expected 0 (none)")
    _check_crc(block + trailer[:1], masked_crc, f"index block at {offset}")
    (restarts,) = struct.unpack("<I", block[-4:])
    end = len(block) - 4 - 4 * restarts
    position, key, pairs = 0, b"", []
    while position < end:
        shared, position = _varint(block, position)
        own, position = _varint(block, position)
        value_length, position = _varint(block, position)
        key = key[:shared] + block[position : position + own]
        position += own
        pairs.append((key, block[position : position + value_length]))
        position += value_length
    return pairs


def _check_header(value):
    shards = sum(number for field, number in _fields(value) if field == 1)
    big_endian = any(number for field, number in _fields(value) if field == 2)
    if shards != 1 or big_endian:
        raise CheckpointError(f"{shards} data files, big endian {big_endian}: expected one of little endian")


def _entry(value):
    """BundleEntryProto: 1 type, 2 shape, 3 shard, 4 offset, 5 size, 6 CRC; absent numbers are 0."""
    fields = {field: content for field, content in _fields(value)}
    kind = fields.get(1, 0)
    if kind not in DTYPES:
        raise CheckpointError(f"tensor type {kind}, expected one of {sorted(DTYPES)}")
    dims = [content for field, content in _fields(fields.get(2, b"")) if field == 2]
    shape = tuple(dict(_fields(dim)).get(1, 0) for dim in dims)
    return Entry(DTYPES[kind], shape, fields.get(4, 0), fields.get(5, 0), fields.get(6, 0))


def _fields(message):
    """Field numbers and contents of a protocol buffer: numbers, or bytes where a length comes first."""
    position = 0
    while position < len(message):
        tag, position = _varint(message, position)
        kind = tag & 7
        if kind == 0:
            content, position = _varint(message, position)
        elif kind == 2:
            length, position = _varint(message, position)
            content, position = message[position : position + length], position + length
        elif kind == 5:
            content, position = struct.unpack("<I", message[position : position + 4])[0], position + 4
        else:
            raise CheckpointError(f"wire type {kind} in the index, expected 0, 2 or 5")
        yield tag >> 3, content


def _handle(data, position):
    offset, position = _varint(data, position)
    length, position = _varint(data, position)
    return offset, length, position


def _varint(data, position):
    number = shift = 0
    while True:
        if position >= len(data) or shift > 63:
            raise CheckpointError("a number runs past the end of its block")
        byte = data[position]
        number |= (byte & 0x7F) << shift
        position, shift = position + 1, shift + 7
        if byte < 0x80:
            return number, position


def _crc_table():
    table = np.arange(256, dtype=np.uint32)
    for _ in range(8):
        table = np.where(table & 1, (table >> 1) ^ np.uint32(0x82F63B78), table >> 1)
    return table


_CRC_BYTE = _crc_table()
# Two bytes a step: the table of 16 bits halves the loop, which is all the time that reading takes.
_PAIRS = np.arange(65536)
_CRC_PAIR = (_CRC_BYTE[(_CRC_BYTE[_PAIRS & 255] & 255) ^ (_PAIRS >> 8)] ^ (_CRC_BYTE[_PAIRS & 255] >> 8)).tolist()


def crc32c(data):
    """CRC-32C (Castagnoli) of bytes."""
    crc, pairs = 0xFFFFFFFF, _CRC_PAIR
    for pair in struct.unpack(f"<{len(data) // 2}H", data[: len(data) // 2 * 2]):
        crc = (crc >> 16) ^ pairs[(crc & 0xFFFF) ^ pair]
    if len(data) % 2:
        crc = (crc >> 8) ^ int(_CRC_BYTE[(crc ^ data[-1]) & 255])
    return crc ^ 0xFFFFFFFF


def mask_crc(crc):
    """The form in which tables store a CRC, so that one over data with CRCs in it is no special number."""
    return (((crc >> 15) | (crc << 17)) + 0xA282EAD8) & 0xFFFFFFFF


def _check_crc(data, masked, what):
    found = mask_crc(crc32c(data))
    if found != masked:
        raise CheckpointError(f"{what}: checksum {found:#010x}, expected {masked:#010x}")
