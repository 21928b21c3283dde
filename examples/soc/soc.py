"""A LiteX system with a VexRiscv, memory and `raypath_device`: python3 soc.py --help."""

import argparse
import itertools
import logging
import os
import pathlib
import re
import struct
import subprocess
import sys
import threading
import types

from litex.build.generic_platform import Pins, Subsignal
from litex.build.io import CRG
from litex.build.sim import SimPlatform
from litex.build.sim.config import SimConfig
from litex.gen import LiteXModule
from litex.soc import software
from litex.soc.cores.cpu import vexriscv
from litex.soc.integration.builder import Builder
from litex.soc.integration.common import get_mem_data
from litex.soc.integration.soc import SoCRegion
from litex.soc.integration.soc_core import SoCCore
from litex.soc.interconnect import axi
from litex_boards.platforms import radiona_ulx3s
from migen import ClockSignal, Instance, ResetSignal, Signal

SOFTWARE = pathlib.Path(software.__path__[0])
HERE = pathlib.Path(__file__).resolve().parent
RAM = 0x4000_0000
DEVICE = 0xB000_0000  # in the CPU's uncached half
COMPILER = ["riscv64-unknown-elf-gcc", "-march=rv32im", "-misa-spec=2.2", "-mabi=ilp32", "-std=gnu11", "-Os"]
COMPILER += ["-Wall", "-Wextra", "-Werror", "-ffreestanding", "-nostdlib", "-static"]
COMPILER += ["-fno-tree-loop-distribute-patterns"]  # else the loop of memcpy becomes a call of memcpy
CLOCK = 25e6  # the board's, without a PLL
LIMIT = 1200  # seconds of a simulation


class Raypath(LiteXModule):
    """`raypath_device`: `registers` is its slave, `memory` its master, `ev.irq` its interrupt."""

    def __init__(self, platform, folder):
        text = (folder / "rtl/raypath_device.sv").read_text()

        def constant(name):
            return int(re.search(rf"\b{name} *= *(\d+)", text)[1])

        if constant("AddressWidth") != 32:
            sys.exit(f"AddressWidth of raypath_device: {constant('AddressWidth')}, expected 32, as LiteX's bus has")
        self.registers = axi.AXILiteInterface(data_width=32, address_width=32)
        # An id is a context and a bit that says whether the read is of a ring.
        id_width = (constant("Contexts") - 1).bit_length() + 1
        self.memory = axi.AXIInterface(
            data_width=constant("DataWidth"), address_width=32, id_width=id_width, bursting=True
        )
        self.ev = types.SimpleNamespace(irq=Signal())  # where LiteX looks for an interrupt
        ports = {"i_clk_i": ClockSignal(), "i_rst_ni": ~ResetSignal(), "o_irq_o": self.ev.irq}

        def connect(prefix, channel, fields, to_device):
            """The ports of a channel; `to_device` tells where its `valid` goes."""
            for field in ("valid", "ready", *fields):
                direction = "i" if to_device != (field == "ready") else "o"
                signal = getattr(channel, field)
                if field == "addr" and to_device:
                    signal = signal[:12]
                ports[f"{direction}_{prefix}{field}"] = signal

        address = ["addr", "prot"]
        for name, fields, to_device in [
            ("aw", address, True),
            ("w", ["data", "strb"], True),
            ("b", ["resp"], False),
            ("ar", address, True),
            ("r", ["data", "resp"], False),
        ]:
            connect(f"s_axi_{name}", getattr(self.registers, name), fields, to_device)
        address = ["id", "addr", "len", "size", "burst", "lock", "cache", "prot", "qos"]
        for name, fields, to_device in [
            ("aw", address, False),
            ("w", ["data", "strb", "last"], False),
            ("b", ["id", "resp"], True),
            ("ar", address, False),
            ("r", ["id", "data", "resp", "last"], True),
        ]:
            connect(f"m_axi_{name}", getattr(self.memory, name), fields, to_device)
        self.specials += Instance("raypath_device", **ports)
        for line in (folder / "raypath_device.f").read_text().split():
            platform.add_source(str(folder / line))


class System(SoCCore):
    """Processor, memory, serial line and device. The firmware is in the memory when the processor starts."""

    def __init__(self, platform, clock, reset, uart, folder):
        self.folder = folder
        self.crg = CRG(clock, reset)
        SoCCore.__init__(
            self,
            platform,
            clk_freq=CLOCK,
            cpu_type="vexriscv",
            cpu_reset_address=RAM,
            integrated_main_ram_size=256 * 1024,  # block RAM on the board, of which an ECP5-85F has 416 KiB
            integrated_sram_size=8192,
            uart_name=uart,
            with_timer=False,
        )
        self.raypath = Raypath(platform, folder)
        self.bus.add_slave("raypath", self.raypath.registers, SoCRegion(DEVICE, 0x1000, cached=False))
        # LiteX's converter to 32 bits takes bursts of up to 1 KiB, and loses the rest of longer ones; the device's have
        # at most 512 bytes. It answers OKAY to each, one after the other.
        self.bus.add_master("raypath", self.raypath.memory)
        self.irq.add("raypath")

    def build(self, *arguments, **options):
        """Compiles the firmware as soon as its headers exist, and before the memory's content is written."""
        build = pathlib.Path(self.builder.output_dir)
        cpu = pathlib.Path(vexriscv.__file__).parent
        image = build / "firmware.elf"
        scene = (self.folder / "scene.bin").stat().st_size
        (build / "rays.bin").write_bytes(rays(self.folder / "rays.txt"))
        headers = [HERE / "firmware", self.builder.include_dir, SOFTWARE / "include", SOFTWARE, cpu]
        command = [*COMPILER, *(f"-isystem{path}" for path in headers), f"-I{HERE.parents[1]}/software"]
        command += [f"-Wl,-T,{HERE}/firmware/linker.ld", f"-L{self.builder.generated_dir}"]
        command += [f"-Wl,--defsym=SCENE_ALIGN={1 << (scene - 1).bit_length()}", f"-Wa,-I{build},-I{self.folder}"]
        command += ["-o", image, cpu / "crt0.S", *sorted((HERE / "firmware").glob("*.[cS]"))]
        if subprocess.run([*command, "-lgcc"]).returncode:
            sys.exit(f"no firmware: the message of {COMPILER[0]} is above; main_ram has to hold it, scene and rays")
        binary = image.with_suffix(".bin")
        subprocess.run(["riscv64-unknown-elf-objcopy", "-O", "binary", image, binary], check=True)
        self.init_ram("main_ram", get_mem_data(str(binary), endianness="little"))
        return super().build(*arguments, **options)


def rays(path):
    """The rays of `raypath render --camera-rays`, as the firmware has them."""
    lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    return b"".join(struct.pack("<7f", *map(float, line.split())) for line in lines)


def hits(lines):
    """The lines of `raypath render --hits`, without decimals, for those of the firmware: by the number of the ray."""
    found = {}
    for line in lines:
        number, status, *words = (int(word, 16) for word in line.split()[1:])
        kind, back = status & 0xFF, "b" * (status >> 8 & 1)
        bits = " ".join(f"{word:08x}" for word in words[1:])
        found[number] = {0: "miss", 1: f"{words[0]}{back} - - - {bits}"}.get(kind, f"status {kind}")
    return found


def compare(folder, lines):
    """Writes the hits to soc-hits.txt, and compares their bits with those of the model, in hits.txt."""
    found = hits(lines)
    model = [line.split() for line in (folder / "hits.txt").read_text().splitlines() if not line.startswith("#")]
    for number, words in enumerate(model):
        expected = " ".join([*words[:1], *["-"] * len(words[1:4]), *words[4:]])
        if found.get(number) != expected:
            sys.exit(f"ray {number}: {found.get(number, 'no hit')}, expected {expected}")
    if len(found) != len(model):
        sys.exit(f"{len(found)} hits, expected {len(model)}")
    (folder / "soc-hits.txt").write_text("".join(f"{found[number]}\n" for number in range(len(model))))


def simulate(folder):
    """Builds the simulation, and returns what the firmware writes."""
    stream = [("valid", 1), ("ready", 1), ("data", 8)]
    pads = [Subsignal(f"{end}_{name}", Pins(width)) for end in ("source", "sink") for name, width in stream]
    platform = SimPlatform("SIM", [("sys_clk", 0, Pins(1)), ("serial", 0, *pads)])
    platform.add_source(str(HERE / "untraced.vlt"))
    config = SimConfig()
    config.add_clocker("sys_clk", freq_hz=CLOCK)
    config.add_module("serial2console", "serial")
    system = System(platform, platform.request("sys_clk"), 0, "sim", folder)
    build = folder / "soc"
    Builder(system, output_dir=build).build(run=False, sim_config=config, opt_level="O1", jobs=os.cpu_count())
    gateware = build / "gateware"
    with open(build / "verilator.log", "w") as log:
        if subprocess.run(["bash", "build_sim.sh"], cwd=gateware, stdout=log, stderr=log).returncode:
            sys.exit(f"Verilator failed: {log.name}")
    with subprocess.Popen(
        [gateware / "obj_dir/Vsim"], cwd=gateware, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as simulation:
        limit = threading.Timer(LIMIT, simulation.kill)
        limit.start()
        lines = list(itertools.takewhile(lambda line: line != "end", map(str.strip, simulation.stdout)))
        ended = limit.is_alive()
        limit.cancel()
        simulation.kill()
    if not ended:
        sys.exit(f"the firmware has not ended after {LIMIT} s")
    return lines


def ulx3s(folder):
    """Builds the bitstream, and prints what it takes and the clock that it reaches."""
    platform = radiona_ulx3s.Platform(device="LFE5U-85F", toolchain="trellis")
    system = System(platform, platform.request("clk25"), platform.request("rst"), "serial", folder)
    build = folder / "ulx3s"
    Builder(system, output_dir=build).build(run=False, build_name="ulx3s", abc9=True)
    tools = build / "tools"
    tools.mkdir(exist_ok=True)
    for tool in ("yosys", "nextpnr-ecp5", "ecppack"):
        (tools / tool).unlink(missing_ok=True)
        (tools / tool).symlink_to(pathlib.Path(sys.executable).parent / f"yowasp-{tool}")
    environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"}
    with open(build / "build.log", "w") as log:
        command = ["bash", "build_ulx3s.sh"]
        if subprocess.run(command, cwd=build / "gateware", env=environment, stdout=log, stderr=log).returncode:
            sys.exit(f"the build failed: {log.name}")
    text = (build / "build.log").read_text()
    for cell in ("TRELLIS_COMB", "TRELLIS_FF", "DP16KD", "MULT18X18D"):
        used, all_ = re.search(rf"{cell}: *(\d+)/ *(\d+)", text).groups()
        print(f"{cell:12} {used:>6} of {all_}")
    # LiteX lets nextpnr end well with a clock that is too slow. The last line is of the routed design.
    reached = float(re.findall(r"Max frequency for clock '[^']*clk25[^']*': ([\d.]+) MHz", text)[-1])
    print(f"clock        {reached:6} MHz of {CLOCK / 1e6:g}")
    if reached < CLOCK / 1e6:
        sys.exit("the board's clock is too fast for the bitstream")
    print(f"wrote {build}/gateware/ulx3s.bit")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path, help="files of `raypath generate --unit`, scene.bin, rays.txt")
    parser.add_argument("--board", choices=["sim", "ulx3s"], default="sim")
    parser.add_argument("--lines", type=pathlib.Path, help="compare what the firmware wrote, and build nothing")
    options = parser.parse_args()
    logging.disable(logging.INFO)
    folder = options.folder.resolve()
    if options.lines is None and options.board == "ulx3s":
        ulx3s(folder)
        return
    lines = simulate(folder) if options.lines is None else options.lines.read_text().splitlines()
    print(*(line for line in lines if line.startswith(("rays", "error"))), sep="\n")
    compare(folder, [line for line in lines if line.startswith("hit")])


if __name__ == "__main__":
    main()
