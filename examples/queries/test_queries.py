"""The rays of both pictures through the Verilated RTL, with shaders that answer late and in another order."""

import json
import os
import pathlib
import random
import struct

import cocotb
from bench import AXI, HIT_FIELDS, RAY, SceneMemory, bits
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from shaders import verdict

FOLDER = pathlib.Path(os.environ["RAYPATH_UNIT"])
CANDIDATE = "tag id is_box primitive t_denom u_num v_num".split()
ANSWER = "valid tag accept end t".split()
HITS = [*HIT_FIELDS, "geometry"]


def number(word):
    return struct.unpack("<f", struct.pack("<I", word))[0]


def weight(numerator, denominator):
    """The quotient in binary32, as the models round it: binary64 has more than twice its bits, so rounding twice is
    rounding once."""
    return number(bits(number(numerator) / number(denominator)))


class Queries:
    """Sends rays, decides about candidates, and receives hits."""

    def __init__(self, dut, picture):
        self.dut, self.rays, self.root = dut, picture["rays"], picture["root"]
        self.hits, self.waiting, self.chance, self.candidates = {}, [], random.Random(5), 0
        ports = [*(f"ray_{name}_i" for name in ["valid", *RAY]), *(f"hit_{name}_o" for name in ["valid", *HITS]),
                 *(f"cand_{name}_o" for name in ["valid", *CANDIDATE]), *(f"answer_{name}_i" for name in ANSWER),
                 *(f"m_axi_{name}" for name in AXI), "clk_i", "rst_ni", "ray_ready_o", "hit_ready_i", "cand_ready_i"]
        # All ports are looked up before cocotbext-axi lists the signals (bench.py says why).
        self.ports = {name: getattr(dut, name) for name in ports}

    def read(self, channel, fields):
        return [int(self.ports[f"{channel}_{name}_o"].value) for name in fields]

    def write(self, channel, fields, values):
        for name, value in zip(fields, values, strict=True):
            self.ports[f"{channel}_{name}_i"].value = value

    async def trace(self):
        dut = self.dut
        cocotb.start_soon(self.send())
        self.write("answer", ANSWER, [0] * 5)
        dut.hit_ready_i.value = dut.cand_ready_i.value = 1
        while len(self.hits) < len(self.rays):
            await RisingEdge(dut.clk_i)
            if dut.hit_valid_o.value:
                ray, status, primitive, t, _, _, _, geometry = self.read("hit", HITS)
                assert ray not in self.hits, f"ray {ray} ends twice"
                # Where there is no hit, Python's models show -1 and infinity.
                is_hit = status in (1, 2)
                self.hits[ray] = (status, geometry, primitive, number(t)) if is_hit else (status, -1, -1, float("inf"))
            if dut.cand_valid_o.value:
                self.candidates += 1
                self.waiting.append(self.read("cand", CANDIDATE))
            self.answer()
        return [self.hits[ray] for ray in range(len(self.rays))]

    def answer(self):
        """Answers about one of the candidates that wait, often later."""
        if not self.waiting or self.chance.random() < 0.2:
            self.ports["answer_valid_i"].value = 0
            return
        asked = self.waiting.pop(self.chance.randrange(len(self.waiting)))
        tag, ray, is_box, primitive, denominator, *weights = asked
        u, v = (0, 0) if is_box else (weight(word, denominator) for word in weights)
        accept, t = verdict(self.rays[ray], is_box, primitive, u, v)
        self.write("answer", ANSWER, [1, tag, accept, 0, bits(t)])

    async def send(self):
        dut = self.dut
        for ray, (origin, direction) in enumerate(self.rays):
            vectors = map(bits, [*origin, *direction, 0.0, float("inf")])
            self.write("ray", ["valid", *RAY], [1, ray, self.root, 0, *vectors])
            await RisingEdge(dut.clk_i)
            while not dut.ray_ready_o.value:
                await RisingEdge(dut.clk_i)
        dut.ray_valid_i.value = 0


async def draw(dut, name):
    picture = json.loads((FOLDER / f"{name}.json").read_text())
    queries = Queries(dut, picture)
    inputs = (dut.ray_valid_i, dut.hit_ready_i, dut.cand_ready_i, dut.answer_valid_i, dut.rst_ni)
    for signal in (dut.flush_i, dut.node_limit_i, dut.invalidate_i, *inputs):
        signal.value = 0
    SceneMemory(dut, bytearray((FOLDER / f"{name}.bin").read_bytes()))
    cocotb.start_soon(Clock(dut.clk_i, 10, "ns").start())
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1
    hits = await queries.trace()
    dut._log.info("%s: %d rays, %d candidates", name, len(hits), queries.candidates)
    (FOLDER / f"{name}-rtl.json").write_text(json.dumps(hits))
    for ray, (found, expected) in enumerate(zip(hits, picture["hits"], strict=True)):
        assert list(found) == expected, f"ray {ray}: {found}, expected {expected}"


@cocotb.test()
async def leaves(dut):
    await draw(dut, "leaves")


@cocotb.test()
async def spheres(dut):
    await draw(dut, "spheres")
