"""Tests of the datapath at its ports: a known job, back pressure, and recorded jobs of the original hardware."""

import gzip
import math
import pathlib
import random
import struct

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, Timer

QUADBOX = 1
LATENCY = 12
CAPACITY = 24
GOLDEN = pathlib.Path(__file__).parents[2] / "crates/raypath/tests/data/golden/quadbox.txt.gz"


def bits(number):
    return struct.unpack("<I", struct.pack("<f", number))[0]


def number(word):
    return struct.unpack("<f", struct.pack("<I", word))[0]


def quadbox(words):
    """The ports of a quadbox job, from the words of a transaction: ray, then four boxes."""
    names = [f"ray_{part}_{axis}" for part in ("origin", "dir", "inv") for axis in "xyz"]
    names += ["ray_extent", "ray_kx", "ray_ky", "ray_kz", "ray_shear_x", "ray_shear_y", "ray_shear_z"]
    names += [f"aabb_{box}_{axis}_{end}" for box in range(4) for end in ("min", "max") for axis in "xyz"]
    return dict(zip(names, words, strict=True), opcode=QUADBOX)


def along_z(boxes):
    """A quadbox job: a ray from (0, 0, -5) along z, and boxes as (min, max)."""
    ray = [0, 0, -5, 0, 0, 1, math.inf, math.inf, 1, math.inf]
    corners = [coordinate for low, high in boxes for coordinate in (*low, *high)]
    return quadbox([bits(x) for x in ray] + [0, 1, 2] + [bits(x) for x in (0, 0, 1)] + [bits(x) for x in corners])


class Bench:
    """Drives clock, reset and ports. Inputs change after the falling edge; outputs are read 1 ns later."""

    @classmethod
    async def start(cls, dut):
        self = cls()
        self.dut = dut
        for signal in (dut.input_valid_i, dut.output_ready_i, dut.rst_ni):
            signal.value = 0
        cocotb.start_soon(Clock(dut.clk_i, 10, "ns").start())
        await FallingEdge(dut.clk_i)
        await FallingEdge(dut.clk_i)
        dut.rst_ni.value = 1
        return self

    async def cycle(self, job, ready):
        """Offers a job or None; returns whether it was accepted, and the outcome at the output or None."""
        dut = self.dut
        await FallingEdge(dut.clk_i)
        dut.input_valid_i.value = job is not None
        dut.output_ready_i.value = ready
        for name, value in (job or {}).items():
            getattr(dut, f"{name}_i").value = value
        await Timer(1, "ns")
        accepted = job is not None and bool(dut.input_ready_o.value)
        return accepted, self.outcome() if dut.output_valid_o.value else None

    def outcome(self):
        """The outcome at the output as distances, hits and indices, in the order of a transaction file."""
        read = lambda name: int(getattr(self.dut, f"{name}_o").value)
        assert read("opcode") == QUADBOX
        hits = [read("is_intersect") >> place & 1 for place in range(4)]
        return [*(read(f"tmin_{i}") for i in range(4)), *hits, *(read(f"box_index_{i}") for i in range(4))]


@cocotb.test()
async def known_answer_after_twelve_cycles(dut):
    bench = await Bench.start(dut)
    near, far = ((-1, -1, -1), (1, 1, 1)), ((-1, -1, 7), (1, 1, 9))
    aside = ((4, 4, 4), (5, 5, 5))
    accepted, outcome = await bench.cycle(along_z([far, aside, near, aside]), True)
    assert accepted and outcome is None
    for _ in range(LATENCY - 1):
        assert (await bench.cycle(None, True))[1] is None
    _, outcome = await bench.cycle(None, True)
    assert [number(t) for t in outcome[:2]] == [4.0, 12.0]
    assert outcome[4:8] == [1, 1, 0, 0] and outcome[8:10] == [2, 0]
    assert (await bench.cycle(None, True))[1] is None


@cocotb.test()
async def back_pressure_loses_nothing(dut):
    bench = await Bench.start(dut)
    boxes = [((-1, -1, z), (1, 1, z + 1)) for z in range(40)]
    jobs = [along_z([box] * 4) for box in boxes]
    sent, shown = 0, []
    for _ in range(60):
        accepted, outcome = await bench.cycle(jobs[sent], False)
        sent += accepted
        shown += [outcome] if outcome else []
    assert sent == CAPACITY, f"{sent} jobs fit"
    assert len(shown) == 60 - LATENCY and all(outcome == shown[0] for outcome in shown)
    distances = []
    while len(distances) < len(jobs):
        accepted, outcome = await bench.cycle(jobs[sent] if sent < len(jobs) else None, True)
        sent += accepted
        distances += [number(outcome[0])] if outcome else []
    assert distances == [z + 5.0 for z in range(40)]


@cocotb.test()
async def outcomes_of_the_original_hardware(dut):
    with gzip.open(GOLDEN, "rt") as lines:
        transactions = [[int(word, 16) for word in line.split()[2:]] for line in lines]
    chance = random.Random(1)
    transactions = chance.sample(transactions, 500)
    bench = await Bench.start(dut)
    sent, taken, job = 0, 0, None
    while taken < len(transactions):
        if job is None and sent < len(transactions) and chance.random() < 0.8:
            job = quadbox(transactions[sent][:40])
        ready = chance.random() < 0.7
        accepted, outcome = await bench.cycle(job, ready)
        if accepted:
            sent, job = sent + 1, None
        if outcome and ready:
            expected = transactions[taken][40:]
            same = [x == y or math.isnan(number(x)) and math.isnan(number(y)) for x, y in zip(outcome, expected, strict=True)]
            assert all(same), f"job {taken}: {outcome}, expected {expected}"
            taken += 1
