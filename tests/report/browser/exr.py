"""Reads the EXR files that a run writes, by the format's definition: a second opinion on the values in a page."""

import struct
import zlib

FLOAT = 2
LINES_OF = {0: 1, 2: 1, 3: 16}  # by compression: none, ZIPS, ZIP


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _attributes(data, at):
    attributes = {}
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)  # its type
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channels(data):
    names, at = [], 0
    while data[at]:
        name, at = _text(data, at)
        if struct.unpack_from("<i", data, at)[0] != FLOAT:
            raise ValueError(f"channel {name} holds no 32-bit floats")
        names.append(name)
        at += 16
    return names


def _inflated(block, size):
    if len(block) == size:  # what does not shrink is stored as it is
        return block
    bytes_ = bytearray(zlib.decompress(block))
    for i in range(1, len(bytes_)):
        bytes_[i] = (bytes_[i - 1] + bytes_[i] - 128) & 255
    half = (size + 1) // 2
    result = bytearray(size)
    result[0::2], result[1::2] = bytes_[:half], bytes_[half:]
    return bytes(result)


def read(path):
    """width, height, and each channel's values row after row, by name."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:5] != b"\x76\x2f\x31\x01\x02":
        raise ValueError(f"{path} is no EXR")
    attributes, at = _attributes(data, 8)
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    lines, names = LINES_OF[attributes["compression"][0]], _channels(attributes["channels"])
    values = {name: [0.0] * (width * height) for name in names}
    for offset in struct.unpack_from(f"<{(height + lines - 1) // lines}Q", data, at):
        y, size = struct.unpack_from("<2i", data, offset)
        rows = range(y - top, min(y - top + lines, height))
        block = _inflated(data[offset + 8:offset + 8 + size], 4 * width * len(names) * len(rows))
        for i, (row, name) in enumerate((row, name) for row in rows for name in names):
            values[name][row * width:(row + 1) * width] = struct.unpack_from(f"<{width}f", block, 4 * width * i)
    return width, height, values
