# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Damage to files that keeps most of their structure, so that it reaches deep into a reader.

All take (data, random) and return data; the same random numbers give the same damage.
"""
import re
import struct
import zlib

import lz4.frame
import zstandard

MAGIC = b'\x89MCAP0\r\n'
MESSAGE, CHUNK = 5, 6
CHUNK_HEAD = struct.Struct('<QQQII')
INTERESTING = (0, 1, 2, 7, 0x7f, 0x80, 0xff, 0x7fff, 0xffff, 1 << 20, 0x7fffffff, 0x80000000,
               0xffffffff, 1 << 40, (1 << 63) - 1, 1 << 63, (1 << 64) - 1)
TOKEN = re.compile(r'[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?|[A-Za-z_/][\w/]*|[^\w\s]|\s+')
NASTY = (
    'nan', '.nan', 'NaN', 'inf', '-.inf', 'Infinity', '1e999', '-1e308', '1e-400', '0', '-0', '-1',
    '', ' ', 'null', '~', 'true', 'no', '0x10', '1_000', '1,5', '12:30:00', '2026-01-01', "'1'",
    '9' * 400, '9' * 5000, '18446744073709551616', '\x00', '\ufeff', '\u2028', '\U0001f600',
    '[', '{', ']', '}', ':', ',', ';', '\t', '#', '"', "'", '\\', '%', '&a', '*a', '<<: *a',
    '!!python/object/apply:os.system ["true"]', '!!binary YQ==', '!!set {a}', '---', '...', '? a',
    '|', '>', '{id: gravity, G: 1.0}', '{"a": [1, {"b": null}]}', '../../etc/passwd',
    '/dev/zero', 'x' * 2000)
WHOLE = (
    b'', b'\xff\xfe\x00\x00', b'\xef\xbb\xbf', b'[' * 20000, b'{"a":' * 20000, b'- ' * 5000,
    b'a: ' * 500, b'{a: ' * 3000, b'\x00' * 5000, b'*a', b'1', b'"text"', b'[]', b'{}', b'null')
LAUGHS = ('a: &a [x, x, x, x, x, x, x, x, x, x]\n' + ''.join(
    f'{chr(b + 1)}: &{chr(b + 1)} [{", ".join(["*" + chr(b)] * 10)}]\n'
    for b in range(ord('a'), ord('i')))).encode()


def damaged_bytes(data, random):
    """Return `data` with a few bytes, numbers or pieces changed, anywhere."""
    data = bytearray(data)
    for _ in range(random.choice((1, 1, 2, 4))):
        at = random.randrange(len(data) + 1)
        kind = random.randrange(7)
        if kind == 0:
            data[at:at + 1] = bytes([random.randrange(256)])
        elif kind == 1:
            size = random.choice((1, 2, 4, 8))
            number = random.choice(INTERESTING) & ((1 << 8 * size) - 1)
            data[at:at + size] = number.to_bytes(size, 'little')
        elif kind == 2:
            del data[at:at + random.choice((1, 4, 8, 100))]
        elif kind == 3:
            other = random.randrange(len(data) + 1)
            data[at:at] = data[other:other + random.choice((1, 8, 50, 500))]
        elif kind == 4:
            data[at:at + 1] = bytes([(data[at] if at < len(data) else 0) ^ 1 << random.randrange(
                8)])
        elif kind == 5:
            data[at:] = b''
        else:
            data[at:at] = bytes(random.choice((1, 3, 8, 64)))
    return bytes(data)


def damaged_text(data, random):
    """Return the text `data` (UTF-8) with some tokens or lines changed."""
    if random.random() < 0.06:
        return random.choice((*WHOLE, LAUGHS, LAUGHS + data))
    if random.random() < 0.1:
        return damaged_bytes(data, random)
    text = data.decode()
    for _ in range(random.choice((1, 1, 1, 2, 5))):
        kind = random.randrange(6)
        if kind == 0:
            lines = text.split('\n')
            at, other = random.randrange(len(lines)), random.randrange(len(lines))
            what = random.randrange(4)
            if what == 0:
                del lines[at]
            elif what == 1:
                lines.insert(at, lines[other])
            elif what == 2:
                lines[at], lines[other] = lines[other], lines[at]
            else:
                lines[at] = ' ' * random.randrange(1, 5) + lines[at]
            text = '\n'.join(lines)
            continue
        tokens = [match.span() for match in TOKEN.finditer(text)]
        if not tokens:
            return text.encode()
        begin, end = random.choice(tokens)
        if kind == 1:  # one for another
            other = random.choice(tokens)
            new = text[slice(*other)]
        elif kind == 2:
            new = ''
        elif kind == 3:
            new = text[begin:end] * 2
        else:
            new = random.choice(NASTY)
        text = text[:begin] + new + text[end:]
    return text.encode(random.choice(('utf-8',) * 9 + ('utf-16',)), 'surrogatepass')


def damaged_mcap(data, random):
    """Return the MCAP file `data` with records, messages or their declared sizes changed."""
    if random.random() < 0.2:
        return damaged_bytes(data, random)
    records = _records(data[len(MAGIC):])
    for _ in range(random.choice((1, 1, 2))):
        at = random.randrange(len(records))
        opcode, body = records[at]
        kind = random.randrange(8)
        if kind == 0:
            del records[at]
            if not records:
                return MAGIC
        elif kind == 1:
            records.insert(random.randrange(len(records)), (opcode, body))
        elif kind == 2:
            other = random.randrange(len(records))
            records[at], records[other] = records[other], records[at]
        elif kind == 3:
            records[at] = (random.randrange(16), body)
        else:
            chunks = [k for k, (code, _) in enumerate(records) if code == CHUNK]
            if chunks and kind > 4:
                at = random.choice(chunks)
                opcode, body = records[at]
            records[at] = (opcode, _damaged_chunk(body, random) if opcode == CHUNK
                           else damaged_bytes(body, random))
    whole = MAGIC + b''.join(_record(code, body) for code, body in records)
    if random.random() < 0.15:  # a length that is not true
        at = random.randrange(len(MAGIC), len(whole))
        whole = whole[:at] + random.choice(INTERESTING).to_bytes(8, 'little') + whole[at + 8:]
    return whole + (MAGIC if random.random() < 0.8 else b'')


def damaged_cdr(data, random):
    """Return the CDR bytes `data` with counts, texts or ends changed."""
    data = bytearray(data)
    for _ in range(random.choice((1, 1, 2, 3))):
        kind = random.randrange(4)
        at = 4 * random.randrange(len(data) // 4 + 1)
        if kind < 2:
            number = random.choice(INTERESTING) & 0xffffffff
            data[at:at + 4] = number.to_bytes(4, 'little')
        elif kind == 2:
            data[at:] = b''
        else:
            return damaged_bytes(data, random)
    return bytes(data)


def _records(data):
    """Return [(opcode, body)] of the records in `data`, as far as they are whole."""
    found, at = [], 0
    while at + 9 <= len(data):
        opcode, length = struct.unpack_from('<BQ', data, at)
        if at + 9 + length > len(data):
            break
        found.append((opcode, data[at + 9:at + 9 + length]))
        at += 9 + length
    return found


def _record(opcode, body):
    return struct.pack('<BQ', opcode, len(body)) + body


def _damaged_chunk(body, random):
    """Return the body of a chunk whose records are damaged, but not the chunk around them."""
    try:
        start, end, size, _, length = CHUNK_HEAD.unpack_from(body)
        name = body[CHUNK_HEAD.size:CHUNK_HEAD.size + length].decode()
        packed = body[CHUNK_HEAD.size + length + 8:]
        inside = _unpacked(packed, name)
    except (struct.error, UnicodeDecodeError, RuntimeError, zstandard.ZstdError):
        return damaged_bytes(body, random)
    records = _records(inside)
    for _ in range(random.choice((1, 1, 3))):
        if not records:
            break
        at = random.randrange(len(records))
        opcode, content = records[at]
        if opcode == MESSAGE and random.random() < 0.8:
            records[at] = (opcode, content[:22] + damaged_cdr(content[22:], random))
        else:
            records[at] = (opcode, damaged_bytes(content, random))
    inside = b''.join(_record(code, content) for code, content in records)
    if random.random() < 0.1:
        inside = damaged_bytes(inside, random)
    size = len(inside)
    crc = zlib.crc32(inside)
    name = random.choice((name, name, name, '', 'lz4', 'zstd', 'gzip'))
    packed = _packed(inside, name)
    if random.random() < 0.15:
        size = random.choice(INTERESTING)
    if random.random() < 0.1:
        start, end = random.choice(INTERESTING), random.choice(INTERESTING)
    head = CHUNK_HEAD.pack(start, end, size, random.choice((crc, crc, crc, 0, 1)), len(name))
    return head + name.encode() + struct.pack('<Q', len(packed)) + packed


def _unpacked(packed, name):
    if name == 'lz4':
        return lz4.frame.decompress(packed)
    if name == 'zstd':
        return zstandard.ZstdDecompressor().decompress(packed)
    return packed


def _packed(data, name):
    if name == 'lz4':
        return lz4.frame.compress(data)
    if name == 'zstd':
        return zstandard.ZstdCompressor().compress(data)
    return data
