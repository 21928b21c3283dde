"""A driver of raypath_unit_axi, and an AXI4 memory with a scene."""

import logging
import random
import struct

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from cocotbext.axi import AxiRamRead, AxiReadBus

MISS, HIT, REFUSED, MEMORY_ERROR = 0, 1, 3, 4
ROOT = 0x20  # the child word of a node at address 0, where `raypath scene` puts the root
CULL_BACK_FACING_TRIANGLES = 1 << 4  # a bit of ray_flags_i

RAY = "id root flags origin_x origin_y origin_z dir_x dir_y dir_z tmin tmax".split()
HIT_FIELDS = "id status primitive t t_num t_denom back_face".split()
AXI = ("arid araddr arlen arsize arburst arlock arcache arprot arqos arvalid arready "
       "rid rdata rresp rlast rvalid rready").split()
PORTS = ["clk_i", "rst_ni", "flush_i", "node_limit_i", "invalidate_i",
         "ray_valid_i", "ray_ready_o", "hit_valid_o", "hit_ready_i",
         *(f"ray_{name}_i" for name in RAY), *(f"hit_{name}_o" for name in HIT_FIELDS),
         *(f"m_axi_{name}" for name in AXI)]


def bits(number):
    return struct.unpack("<I", struct.pack("<f", number))[0]


def find_ports(dut):
    """Looks every port up by its name. cocotbext-axi asks for signals that the unit does not have, and then cocotb lists
    all signals of the module; those of the list are copies of the ports in Verilator 5.006, and writes to them have no
    effect. What was found before by its name stays."""
    for name in PORTS:
        getattr(dut, name)


class SceneMemory(AxiRamRead):
    """A scene from address 0 on; reads behind its end return SLVERR. With a seed, bursts return in any order, and their
    beats are interleaved."""

    def __init__(self, dut, scene, seed=None):
        self.chance = seed and random.Random(seed)
        # cocotbext-axi logs every burst.
        logging.getLogger("cocotb.raypath_unit_axi.m_axi").setLevel(logging.ERROR)
        super().__init__(AxiReadBus.from_prefix(dut, "m_axi"), dut.clk_i, dut.rst_ni, reset_active_level=False,
                         size=len(scene), mem=scene)

    async def _read(self, address, length):
        if address + length > self.size:
            raise IndexError(f"no scene at address {address:#x}")
        return await super()._read(address, length)

    async def _process_read(self):
        if not self.chance:
            await super()._process_read()
        bursts = []
        while True:
            # A few cycles later than the first burst, so that others come in between.
            if not bursts or self.chance.random() < 0.3:
                bursts += [await self.burst()] if not bursts else []
                while not self.ar_channel.empty():
                    bursts.append(await self.burst())
            burst = self.chance.choice(bursts)
            await self.r_channel.send(burst.pop(0))
            bursts = [burst for burst in bursts if burst]

    async def burst(self):
        """The beats of the next burst."""
        request = await self.ar_channel.recv()
        size, count = 1 << int(request.arsize), int(request.arlen) + 1
        assert int(request.arburst) == 1 and int(request.araddr) % (size * count) == 0
        beats = []
        for number in range(count):
            address = int(request.araddr) + number * size
            is_there = address + size <= self.size
            data = await self._read(address, size) if is_there else bytes(size)
            beats.append(self.r_channel._transaction_obj(rid=int(request.arid), rdata=int.from_bytes(data, "little"),
                                                         rresp=0 if is_there else 2, rlast=number == count - 1))
        return beats


class Unit:
    """Sends rays and receives hits. Signals are read at the rising edge of the clock and changed after it."""

    @classmethod
    async def start(cls, dut, scene, seed=None):
        self = cls()
        self.dut, self.hits, self.cycles = dut, {}, 0
        find_ports(dut)
        for signal in (dut.flush_i, dut.node_limit_i, dut.invalidate_i, dut.ray_valid_i, dut.hit_ready_i, dut.rst_ni):
            signal.value = 0
        self.memory = SceneMemory(dut, scene, seed)
        cocotb.start_soon(Clock(dut.clk_i, 10, "ns").start())
        await RisingEdge(dut.clk_i)
        await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1
        return self

    async def trace(self, rays, root=ROOT, ready=lambda: True):
        """Traces rays (ox, oy, oz, dx, dy, dz, extent), and returns the hit of each: status, primitive, the bits of t,
        t_num and t_denom, whether it is a back face."""
        assert len(rays) <= 1 << len(self.dut.ray_id_i), "more rays than numbers"
        cocotb.start_soon(self.send(rays, root))
        self.hits = {}
        limit = self.cycles + 100 * len(rays) + 20_000
        while len(self.hits) < len(rays):
            assert self.cycles < limit, f"{len(self.hits)} of {len(rays)} rays ended"
            is_ready = ready()
            self.dut.hit_ready_i.value = is_ready
            await RisingEdge(self.dut.clk_i)
            self.cycles += 1
            if is_ready and self.dut.hit_valid_o.value:
                self.receive()
        self.dut.hit_ready_i.value = 0
        return [self.hits[number] for number in range(len(rays))]

    async def send(self, rays, root):
        dut = self.dut
        ports = [getattr(dut, f"ray_{name}_i") for name in RAY]
        for number, (*vectors, extent) in enumerate(rays):
            child = root(number) if callable(root) else root
            values = [number, child, CULL_BACK_FACING_TRIANGLES, *map(bits, vectors), bits(0.0), bits(extent)]
            for port, value in zip(ports, values, strict=True):
                port.value = value
            dut.ray_valid_i.value = 1
            await RisingEdge(dut.clk_i)
            while not dut.ray_ready_o.value:
                await RisingEdge(dut.clk_i)
        dut.ray_valid_i.value = 0

    def receive(self):
        number, *hit = [int(getattr(self.dut, f"hit_{name}_o").value) for name in HIT_FIELDS]
        assert number not in self.hits, f"ray {number} ends twice"
        self.hits[number] = tuple(hit)
