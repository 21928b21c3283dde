"""Tests of the traversal unit behind AXI4: the rays of a picture, a hostile memory, a memory without a scene."""

import os
import pathlib
import random
import struct

import cocotb

from bench import CULL_BACK_FACING_TRIANGLES, HIT, MEMORY_ERROR, MISS, ROOT, Unit

FOLDER = pathlib.Path(os.environ["RAYPATH_UNIT"])
SCENE = (FOLDER / "scene.bin").read_bytes()


def lines(name):
    text = (FOLDER / name).read_text().splitlines()
    return [line for line in text if line and not line.startswith("#")]


RAYS = [tuple(map(float, line.split())) for line in lines("rays.txt")]
HITS = lines("hits.txt")


def line(hit):
    """A hit as a line of the file that `raypath render --hits` writes."""
    status, triangle, *words, back_face = hit
    if status == MISS:
        return "miss"
    assert status == HIT
    numbers = [struct.unpack("<f", struct.pack("<I", word))[0] for word in words]
    return " ".join([f"{triangle}{'b' * back_face}", *map(repr, numbers), *(f"{word:08x}" for word in words)])


def same(found, expected):
    """Whether two lines have the same triangle and the same bits."""
    found, expected = found.split(), expected.split()
    return found[:1] + found[4:] == expected[:1] + expected[4:]


def check(hits, expected):
    for number, (hit, wanted) in enumerate(zip(hits, expected, strict=True)):
        assert same(line(hit), wanted), f"ray {number}: {line(hit)}, expected {wanted}"


@cocotb.test()
async def the_picture(dut):
    """All rays of the picture. Writes rtl-hits.txt, for `raypath render --draw`."""
    unit = await Unit.start(dut, bytearray(SCENE))
    hits = await unit.trace(RAYS)
    dut._log.info("%d rays in %d cycles", len(hits), unit.cycles)
    (FOLDER / "rtl-hits.txt").write_text("".join(f"{line(hit)}\n" for hit in hits))
    check(hits, HITS)


@cocotb.test()
async def bursts_in_any_order(dut):
    """Beats of different bursts are interleaved; addresses, beats, rays and hits stall."""
    chance = random.Random(2)
    chosen = sorted(chance.sample(range(len(RAYS)), min(200, len(RAYS))))
    unit = await Unit.start(dut, bytearray(SCENE), seed=3)
    stalls = lambda share: iter(lambda: chance.random() < share, None)
    unit.memory.ar_channel.set_pause_generator(stalls(0.3))
    unit.memory.r_channel.set_pause_generator(stalls(0.2))
    hits = await unit.trace([RAYS[number] for number in chosen], ready=lambda: chance.random() < 0.7)
    check(hits, [HITS[number] for number in chosen])


@cocotb.test()
async def errors_end_their_rays_alone(dut):
    """Every third ray has a root behind the end of the scene, where the memory answers SLVERR."""
    behind = (len(SCENE) + 127) // 128 * 128 | ROOT
    unit = await Unit.start(dut, bytearray(SCENE))
    rays = RAYS[-200:]
    hits = await unit.trace(rays, root=lambda number: behind if number % 3 == 0 else ROOT)
    failed = [number for number, hit in enumerate(hits) if hit[0] == MEMORY_ERROR]
    assert failed == list(range(0, len(rays), 3))
    others = [number for number in range(len(rays)) if number % 3]
    check([hits[number] for number in others], [HITS[-200:][number] for number in others])
