// The SystemC module beside the Verilated RTL of the same configuration, under random bubbles, stalls and resets: equal
// in every cycle. The argument is the configuration's file.
#include "../check.hpp"
#include "raypath_module.hpp"

#include <Vraypath.h>

#include <map>
#include <memory>
#include <random>

using raypath::systemc::Module;
using Word = Module::Word;

namespace {

/// A port of the Verilated model, which has the SystemC type of its width, and the signal that is bound to it.
class Pin {
 public:
  virtual ~Pin() = default;
  virtual void write(Word word) = 0;
  virtual Word read() const = 0;

  /// Binds a new signal to a port of the model that SystemC finds by name. Exits if there is none.
  static std::unique_ptr<Pin> of(const std::string &name);
};

template <typename T>
class PinOf final : public Pin {
 public:
  static std::unique_ptr<Pin> bind(sc_core::sc_object *port) {
    auto pin = std::make_unique<PinOf<T>>();
    if (auto *in = dynamic_cast<sc_core::sc_in<T> *>(port)) {
      in->bind(pin->signal_);
    } else if (auto *out = dynamic_cast<sc_core::sc_out<T> *>(port)) {
      out->bind(pin->signal_);
    } else {
      return nullptr;
    }
    return pin;
  }
  void write(Word word) override { signal_.write(static_cast<T>(word)); }
  Word read() const override { return static_cast<Word>(signal_.read()); }

 private:
  sc_core::sc_signal<T> signal_;
};

std::unique_ptr<Pin> Pin::of(const std::string &name) {
  sc_core::sc_object *port = sc_core::sc_find_object(("rtl." + name).c_str());
  if (auto pin = PinOf<bool>::bind(port)) return pin;
  if (auto pin = PinOf<std::uint32_t>::bind(port)) return pin;
  if (auto pin = PinOf<std::uint64_t>::bind(port)) return pin;
  std::cerr << "the Verilated RTL has no port " << name << '\n';
  std::exit(1);
}

/// A word for an input port. Numbers are often ordinary, so that boxes and triangles are hit.
Word stimulus(std::mt19937 &random, const raypath_port &port) {
  const std::string name = port.name;
  // An axis.
  if (name == "ray_kx" || name == "ray_ky" || name == "ray_kz") return random() % 3;
  const Word bits = Word{random()} << 32 | random();
  const Word mask = port.width < 64 ? (Word{1} << port.width) - 1 : ~Word{0};
  if (port.kind != RAYPATH_PORT_NUMBER || port.width != 32 || random() % 8 == 0) return bits & mask;
  const float number = static_cast<float>(static_cast<int>(random() % 4001) - 2000) / 256;
  std::uint32_t word;
  std::memcpy(&word, &number, sizeof word);
  return word;
}

}  // namespace

int sc_main(int argc, char **argv) {
  CHECK_EQUAL(argc, 2);
  const raypath::Datapath datapath = value(raypath::Datapath::open(read_file(argv[1]).c_str()));

  Module model("model", datapath, value(raypath::Pipeline::create(datapath)));
  Vraypath rtl("rtl");

  // Clock, reset and handshakes have the same type in both.
  sc_core::sc_signal<bool> clk, rst, input_valid, output_ready;
  sc_core::sc_signal<bool> input_ready[2], output_valid[2];
  model.clk_i(clk), rtl.clk_i(clk);
  model.rst_ni(rst), rtl.rst_ni(rst);
  model.input_valid_i(input_valid), rtl.input_valid_i(input_valid);
  model.output_ready_i(output_ready), rtl.output_ready_i(output_ready);
  model.input_ready_o(input_ready[0]), rtl.input_ready_o(input_ready[1]);
  model.output_valid_o(output_valid[0]), rtl.output_valid_o(output_valid[1]);

  // The others are bound by name.
  struct Port {
    sc_core::sc_signal<Word> model;
    std::unique_ptr<Pin> rtl;
  };
  std::map<std::string, Port> inputs, outputs;
  model.opcode_i(inputs["opcode_i"].model);
  model.opcode_o(outputs["opcode_o"].model);
  for (const std::string &name : model.input_names()) model.input(name)(inputs[name].model);
  for (const std::string &name : model.output_names()) model.output(name)(outputs[name].model);
  for (auto &[name, port] : inputs) port.rtl = Pin::of(name);
  for (auto &[name, port] : outputs) port.rtl = Pin::of(name);

  std::map<std::string, raypath_port> ports;
  std::vector<Word> opcodes;
  for (std::size_t i = 0; i < raypath_operation_count(datapath.get()); ++i) {
    raypath_operation_info operation;
    CHECK_EQUAL(raypath_operation(datapath.get(), i, &operation), RAYPATH_OK);
    opcodes.push_back(operation.opcode);
    for (std::size_t j = 0; j < operation.inputs; ++j) {
      raypath_port port;
      CHECK_EQUAL(raypath_input(datapath.get(), i, j, &port), RAYPATH_OK);
      ports[port.name + std::string("_i")] = port;
    }
  }

  std::mt19937 random(1);
  const auto drive = [&](const std::string &name, Word word) {
    inputs[name].model.write(word);
    inputs[name].rtl->write(word);
  };
  // Verilator resets registers at the falling edge.
  rst.write(true);
  sc_core::sc_start(5, sc_core::SC_NS);
  std::size_t entered = 0, left = 0, held_back = 0, stalled = 0, resets = 0;
  constexpr std::size_t cycles = 20000;
  for (std::size_t cycle = 0; cycle < cycles; ++cycle) {
    // Phases with many and few jobs, and with a sink that is often and seldom ready.
    const std::size_t phase = cycle / 500 % 4;
    const bool reset = cycle < 2 || random() % 3000 == 0;
    clk.write(false);
    rst.write(!reset);
    input_valid.write(random() % 8 < (phase < 2 ? 7u : 3u));
    output_ready.write(random() % 8 < (phase % 2 == 0 ? 7u : 2u));
    drive("opcode_i", opcodes[random() % opcodes.size()]);
    for (const std::string &name : model.input_names()) drive(name, stimulus(random, ports.at(name)));
    sc_core::sc_start(5, sc_core::SC_NS);

    // The cycle before the rising edge.
    CHECK_EQUAL(input_ready[0].read(), input_ready[1].read());
    CHECK_EQUAL(output_valid[0].read(), output_valid[1].read());
    if (output_valid[0].read()) {
      for (const auto &[name, port] : outputs) {
        if (port.model.read() == port.rtl->read()) continue;
        std::cerr << "cycle " << cycle << ": " << name << " is " << port.model.read() << ", in the RTL "
                  << port.rtl->read() << '\n';
        return 1;
      }
    }
    resets += reset;
    entered += !reset && input_valid.read() && input_ready[0].read();
    held_back += input_valid.read() && !input_ready[0].read();
    left += !reset && output_valid[0].read() && output_ready.read();
    stalled += output_valid[0].read() && !output_ready.read();
    clk.write(true);
    sc_core::sc_start(5, sc_core::SC_NS);
  }
  std::cout << cycles << " cycles equal: " << entered << " jobs entered, " << left << " left; the source was held back in "
            << held_back << ", the sink stalled in " << stalled << ", " << resets << " resets\n";
  // The traffic reached what it is meant to test.
  CHECK_EQUAL(left > cycles / 4, true);
  CHECK_EQUAL(held_back > cycles / 20, true);
  CHECK_EQUAL(stalled > cycles / 20, true);
  CHECK_EQUAL(resets > 3, true);
  return 0;
}
