// The traversal unit in an architecture simulator: rays go in, hits come out, and blocks are read from the host's
// memory. docs/integration/simulators.md says where hosts in the style of GPGPU-Sim and gem5 call it.
#pragma once

#include <raypath.hpp>

#include <cstdint>
#include <deque>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace raypath::host {

/// The host's memory.
class Memory {
 public:
  virtual ~Memory() = default;
  /// A read of `bytes` bytes: whether the memory takes it in this cycle. The answer is `RayUnit::respond` with the tag.
  virtual bool read(std::uint64_t address, std::uint32_t bytes, std::uint32_t tag) = 0;
};

/// A unit with its own clock. `cycle` is the clock edge; `issue`, `respond` and `retire` act in the cycle before it.
class RayUnit {
 public:
  /// Throws `std::runtime_error` if the model cannot be made.
  RayUnit(const Unit &unit, Memory &memory) : memory_(memory), model_(made(unit)), outputs_(model_.outputs()) {
    const auto parameters = unit.parameters();
    block_bytes_ = parameters.block_bytes;
    beat_bytes_ = parameters.memory_width / 8;
  }

  /// Offers a ray in this cycle: whether the unit accepts it. It accepts one ray in a cycle.
  bool issue(const UnitRay &ray, std::uint64_t id) {
    if (!outputs_.ray_ready || inputs_.ray_valid) return false;
    inputs_.ray = ray;
    inputs_.ray_id = id;
    inputs_.ray_valid = 1;
    return true;
  }

  /// A block has arrived: as many bytes as were read, which are copied, or NULL for an error of the memory. Its beats
  /// enter from this cycle on, one a cycle.
  void respond(std::uint32_t tag, const std::uint8_t *data) {
    Block block{tag, data == nullptr, std::vector<std::uint8_t>(block_bytes_), 0};
    if (data != nullptr) block.bytes.assign(data, data + block_bytes_);
    blocks_.push_back(std::move(block));
  }

  /// The id of the ray that has ended in this cycle, and its hit. A cycle without the call stalls the hits.
  std::optional<std::pair<std::uint64_t, UnitHit>> retire() {
    if (!outputs_.hit_valid || inputs_.hit_ready) return std::nullopt;
    inputs_.hit_ready = 1;
    return std::make_pair(outputs_.hit_id, outputs_.hit);
  }

  /// The clock edge.
  void cycle() {
    if (outputs_.mem_req_valid) {
      inputs_.mem_req_ready = memory_.read(outputs_.mem_req_addr, block_bytes_, outputs_.mem_req_tag);
    }
    if (!blocks_.empty()) {
      Block &block = blocks_.front();
      inputs_.mem_rsp_valid = 1;
      inputs_.mem_rsp_tag = block.tag;
      inputs_.mem_rsp_error = block.is_error;
      inputs_.mem_rsp_data = block.bytes.data() + block.sent;
      block.sent += beat_bytes_;
    }
    if (const auto stepped = model_.step(inputs_); !stepped) throw std::runtime_error(stepped.error().message);
    if (!blocks_.empty() && blocks_.front().sent == block_bytes_) blocks_.pop_front();
    advance();
  }

  /// Passes up to `cycles` cycles in which the host does nothing, and stops where it could: the number of cycles. An
  /// event-driven host calls it between its events.
  std::uint64_t skip(std::uint64_t cycles) {
    if (inputs_.ray_valid || inputs_.hit_ready || !blocks_.empty()) return 0;
    const std::uint64_t passed = model_.skip(cycles);
    advance();
    return passed;
  }

  /// Whether a ray would be accepted in this cycle.
  bool is_ready() const { return outputs_.ray_ready && !inputs_.ray_valid; }

  const UnitModel &model() const { return model_; }

 private:
  struct Block {
    std::uint32_t tag;
    bool is_error;
    std::vector<std::uint8_t> bytes;
    std::uint32_t sent;
  };

  static UnitModel made(const Unit &unit) {
    auto model = UnitModel::create(unit);
    if (!model) throw std::runtime_error(model.error().message);
    return *std::move(model);
  }

  void advance() {
    inputs_ = {};
    outputs_ = model_.outputs();
  }

  Memory &memory_;
  UnitModel model_;
  UnitOutputs outputs_;
  UnitInputs inputs_{};
  std::deque<Block> blocks_;
  std::uint32_t block_bytes_, beat_bytes_;
};

}  // namespace raypath::host
