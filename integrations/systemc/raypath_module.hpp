// The datapath as a SystemC module with the ports of the RTL module `raypath`. docs/integration/systemc.md describes it.
#pragma once

#include <raypath.hpp>

#include <systemc>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace raypath::systemc {

/// A datapath of any configuration. Clock, reset, handshakes and opcodes are members; `input` and `output` find the
/// ports of the operations by the names that they have in the RTL. The low bits of a port are its word.
///
/// In every cycle, `input_ready_o` and `output_valid_o` are those of the RTL. If `output_valid_o` is 1, so are
/// `opcode_o` and all outputs; otherwise these are 0, and those of the RTL are not specified.
class Module : public sc_core::sc_module {
 public:
  using Word = std::uint64_t;

  sc_core::sc_in<bool> clk_i{"clk_i"}, rst_ni{"rst_ni"}, input_valid_i{"input_valid_i"}, output_ready_i{"output_ready_i"};
  sc_core::sc_out<bool> input_ready_o{"input_ready_o"}, output_valid_o{"output_valid_o"};
  sc_core::sc_in<Word> opcode_i{"opcode_i"};
  sc_core::sc_out<Word> opcode_o{"opcode_o"};

  /// The pipeline is empty and one of the datapath.
  Module(const sc_core::sc_module_name &name, const Datapath &datapath, Pipeline pipeline)
      : sc_module(name), pipeline_(std::move(pipeline)) {
    for (std::size_t i = 0; i < raypath_operation_count(datapath.get()); ++i) {
      raypath_operation_info info;
      check(raypath_operation(datapath.get(), i, &info));
      Operation &operation = operations_[info.opcode];
      for (std::size_t j = 0; j < info.inputs; ++j) {
        raypath_port port;
        check(raypath_input(datapath.get(), i, j, &port));
        operation.inputs.push_back(insert(input_names_, port.name + std::string("_i")));
      }
      for (std::size_t j = 0; j < info.outputs; ++j) {
        raypath_port port;
        check(raypath_output(datapath.get(), i, j, &port));
        operation.outputs.push_back(insert(output_names_, port.name + std::string("_o")));
      }
    }
    inputs_.init(input_names_.size(), [this](const char *, std::size_t i) {
      return new sc_core::sc_in<Word>(input_names_[i].c_str());
    });
    outputs_.init(output_names_.size(), [this](const char *, std::size_t i) {
      return new sc_core::sc_out<Word>(output_names_[i].c_str());
    });
    SC_HAS_PROCESS(Module);
    SC_METHOD(update);
    // `input_ready_o` depends on `opcode_i` in configurations with credits and several steps per unit.
    sensitive << clk_i.pos() << rst_ni << opcode_i;
  }

  /// The names of the operations' ports, with `_i` and `_o`.
  const std::vector<std::string> &input_names() const { return input_names_; }
  const std::vector<std::string> &output_names() const { return output_names_; }

  /// A port by its name, for example `ray_origin_x_i`. Throws `std::out_of_range` if the configuration lacks it.
  sc_core::sc_in<Word> &input(const std::string &name) { return inputs_[index(input_names_, name)]; }
  sc_core::sc_out<Word> &output(const std::string &name) { return outputs_[index(output_names_, name)]; }

 private:
  /// For each port of an operation, its index in `inputs_` or `outputs_`.
  struct Operation {
    std::vector<std::size_t> inputs, outputs;
  };

  static void check(raypath_status status) {
    if (status < 0) throw std::runtime_error(raypath_last_error());
  }

  /// The index of a name, or of the end.
  static std::size_t find(const std::vector<std::string> &names, const std::string &name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  }

  static std::size_t index(const std::vector<std::string> &names, const std::string &name) {
    const std::size_t found = find(names, name);
    if (found == names.size()) throw std::out_of_range("the datapath has no port " + name);
    return found;
  }

  /// The index of a name, which is added if it is new: operations share ports.
  static std::size_t insert(std::vector<std::string> &names, const std::string &name) {
    const std::size_t found = find(names, name);
    if (found == names.size()) names.push_back(name);
    return found;
  }

  void update() {
    if (!rst_ni.read()) {
      pipeline_.reset();
    } else if (clk_i.posedge()) {
      edge();
    }
    input_ready_o.write(pipeline_.input_ready(opcode_i.read()));
    const std::optional<Result> result = pipeline_.peek();
    output_valid_o.write(result.has_value());
    opcode_o.write(result ? result->output.words.opcode : 0);
    std::vector<Word> words(outputs_.size(), 0);
    if (result) {
      const std::vector<std::size_t> &ports = operations_.at(result->output.words.opcode).outputs;
      for (std::size_t i = 0; i < ports.size(); ++i) words[ports[i]] = result->output.words.outputs[i];
    }
    for (std::size_t i = 0; i < words.size(); ++i) outputs_[i].write(words[i]);
  }

  void edge() {
    const Word opcode = opcode_i.read();
    if (input_valid_i.read() && pipeline_.input_ready(opcode)) {
      const auto operation = operations_.find(opcode);
      if (operation == operations_.end()) throw std::out_of_range("no operation has opcode " + std::to_string(opcode));
      std::vector<Word> words;
      for (const std::size_t port : operation->second.inputs) words.push_back(inputs_[port].read());
      Job job{};
      job.kind = RAYPATH_JOB_WORDS;
      job.input.words = {opcode, words.data(), words.size()};
      const auto accepted = pipeline_.offer(job, 0);
      if (!accepted) throw std::runtime_error(accepted.error().message);
    }
    pipeline_.step(output_ready_i.read());
  }

  std::vector<std::string> input_names_, output_names_;
  Pipeline pipeline_;
  /// By opcode.
  std::map<Word, Operation> operations_;
  sc_core::sc_vector<sc_core::sc_in<Word>> inputs_{"inputs"};
  sc_core::sc_vector<sc_core::sc_out<Word>> outputs_{"outputs"};
};

}  // namespace raypath::systemc
