// The traversal unit in two hosts: one that calls it in every cycle, as GPGPU-Sim does, and one with events, as gem5.
#include "../check.hpp"
#include "raypath_ray_unit.hpp"

#include <cmath>
#include <cstring>
#include <random>

using raypath::host::RayUnit;
using Cycle = std::uint64_t;

namespace {

/// A memory that takes a read in two cycles of three and answers after a constant latency, in order.
class FixedLatency : public raypath::host::Memory {
 public:
  explicit FixedLatency(const raypath::Scene &scene) : scene_(scene.bytes()) {}

  bool read(std::uint64_t address, std::uint32_t bytes, std::uint32_t tag) override {
    CHECK_EQUAL(address + bytes <= scene_.size(), true);
    if (now % 3 == 0) return false;
    pending_.push_back({now + 40, address, tag});
    return true;
  }

  /// Delivers what is due.
  void deliver(RayUnit &unit) {
    while (!pending_.empty() && pending_.front().due <= now) {
      unit.respond(pending_.front().tag, scene_.data() + pending_.front().address);
      pending_.pop_front();
    }
  }

  Cycle next() const { return pending_.empty() ? now + 1000 : pending_.front().due; }

  Cycle now = 0;

 private:
  struct Read {
    Cycle due;
    std::uint64_t address;
    std::uint32_t tag;
  };
  raypath::Span<const std::uint8_t> scene_;
  std::deque<Read> pending_;
};

struct Run {
  std::vector<raypath::UnitHit> hits;
  std::vector<Cycle> cycles;
};

/// Traces rays. With events, the host is called only where something can happen.
Run run(const raypath::Unit &unit, const raypath::Scene &scene, const std::vector<raypath::UnitRay> &rays, bool events) {
  FixedLatency memory(scene);
  RayUnit traced(unit, memory);
  Run found{std::vector<raypath::UnitHit>(rays.size()), std::vector<Cycle>(rays.size())};
  std::size_t issued = 0, ended = 0;
  while (ended < rays.size()) {
    memory.deliver(traced);
    if (issued < rays.size() && traced.issue(rays[issued], issued)) issued++;
    if (const auto hit = traced.retire()) {
      found.hits[hit->first] = hit->second;
      found.cycles[hit->first] = memory.now;
      ended++;
    }
    const Cycle passed = events ? traced.skip(memory.next() - memory.now) : 0;
    if (passed == 0) traced.cycle();
    memory.now += passed == 0 ? 1 : passed;
  }
  CHECK_EQUAL(traced.model().counts().cycles, memory.now);
  CHECK_EQUAL(traced.model().stalls().request_stalls > 0, true);
  CHECK_EQUAL(traced.model().stalls().rays_inside, 0u);
  return found;
}

}  // namespace

int main() {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> number(-1, 1);
  std::vector<float> corners(3 * 900);
  for (float &x : corners) x = number(random);
  const auto *vertices = reinterpret_cast<const raypath::Scene::Vertex *>(corners.data());
  std::vector<std::uint32_t> places(900);
  for (std::uint32_t i = 0; i < places.size(); i++) places[i] = i;
  const auto *triangles = reinterpret_cast<const raypath::Scene::Triangle *>(places.data());
  const raypath::Unit unit = value(raypath::Unit::open("preset = \"compact\"\ncontexts = 16"));
  const raypath::Scene scene = value(raypath::Scene::build(unit, {vertices, 900}, {triangles, 300}));

  std::vector<raypath::UnitRay> rays(500);
  for (raypath::UnitRay &ray : rays) {
    ray = {};
    for (int axis = 0; axis < 3; axis++) ray.origin[axis] = number(random), ray.direction[axis] = number(random);
    ray.t_max = INFINITY;
    ray.root = scene.root();
  }
  std::vector<raypath::UnitHit> expected(rays.size());
  CHECK_EQUAL(static_cast<bool>(unit.trace(scene.bytes(), rays, expected)), true);
  const Run clocked = run(unit, scene, rays, false), by_events = run(unit, scene, rays, true);
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); i++) {
    CHECK_EQUAL(std::memcmp(&clocked.hits[i], &expected[i], sizeof expected[i]), 0);
    CHECK_EQUAL(std::memcmp(&by_events.hits[i], &expected[i], sizeof expected[i]), 0);
    CHECK_EQUAL(by_events.cycles[i], clocked.cycles[i]);
    hits += expected[i].status == RAYPATH_UNIT_HIT;
  }
  CHECK_EQUAL(hits > 100 && hits < 500, true);
}
