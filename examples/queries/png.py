"""Pictures as PNG."""

import struct
import zlib


def png(path, width, height, pixels):
    """Writes a picture."""
    rows = b"".join(b"\0" + bytes(sum(pixels[row * width : (row + 1) * width], ())) for row in range(height))
    chunk = lambda name, data: struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    header = chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
