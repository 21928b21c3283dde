// The C++ layer: ownership, spans, errors as values, and threads that share a datapath.

#include <raypath.hpp>

#include "check.h"

#include <array>
#include <cmath>
#include <thread>
#include <vector>

static_assert(sizeof(raypath::Ray) == 64 && sizeof(raypath::Box) == 24 && sizeof(raypath::Vertices) == 36);
static_assert(sizeof(raypath::QuadboxResult) == 24 && sizeof(raypath::TriangleResult) == 12);
static_assert(!std::is_copy_constructible_v<raypath::Datapath> && !std::is_copy_constructible_v<raypath::Pipeline>);
static_assert(std::is_nothrow_move_constructible_v<raypath::Datapath>);

static void errors() {
  auto wrong = raypath::Datapath::open("lanes = 3");
  CHECK(!wrong && wrong.error().status == RAYPATH_ERROR_CONFIGURATION);
  CHECK(wrong.error().message.find("lanes") != std::string::npos);
  CHECK(!raypath::ray({0, 0, 0}, {0, 0, 0}, 1.0f));

  auto datapath = raypath::Datapath::open();
  CHECK(datapath && datapath.error().status == RAYPATH_OK);
  std::vector<raypath::Ray> rays(3);
  std::vector<raypath::Box> boxes(11);
  std::vector<raypath::QuadboxResult> results(3);
  CHECK(datapath->quadbox(rays, boxes, results).error().status == RAYPATH_ERROR_ARGUMENT);
  boxes.resize(12);
  CHECK(datapath->quadbox(rays, boxes, results));
  std::array<float, 20> a{}, b{};
  float distances[2];
  CHECK(datapath->euclidean(a, b, 10, distances));
  CHECK(!datapath->euclidean(a, b, 9, distances));
  CHECK(!datapath->generate("/dev/null/x"));
}

static void ownership() {
  auto datapath = raypath::Datapath::open("preset = \"credit\"");
  CHECK(datapath && datapath->latency() == 12 && datapath->capacity() == 13 && datapath->lanes() == 16);
  CHECK(std::string(datapath->description()).find("credit") != std::string::npos && datapath->cost().flip_flops == 7298);
  auto pipeline = raypath::Pipeline::create(*datapath);
  CHECK(pipeline);
  raypath::Datapath moved = std::move(*datapath);
  raypath::Pipeline other = std::move(*pipeline);
  const auto ray = raypath::ray({0, 0, -5}, {0, 0, 1}, INFINITY);
  const raypath::Box box = {{-1, -1, 1}, {1, 1, 2}};
  const auto accepted = other.offer(raypath::quadbox_job(*ray, {box, box, box, box}), 42);
  CHECK(accepted && *accepted);
  CHECK(other.skip(100) == 12 && other.output_valid() && other.occupancy() == 1);
  const auto result = other.step(true);
  CHECK(result && result->tag == 42 && result->output.quadbox.tmin[3] == 6.0f);
  CHECK(!other.step(true));
  CHECK(*other.offer(raypath::triangle_job(*ray, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), 1));
  CHECK(!other.offer(raypath::timing_job(9), 2));
  other.reset();
  CHECK(other.occupancy() == 0 && other.input_ready(1));
}

// Threads share a datapath, each with a pipeline of its own, and have the results of one thread.
static void threads() {
  const auto datapath = raypath::Datapath::open();
  constexpr std::size_t kPairs = 500, kDimensions = 33;
  std::vector<float> a(kPairs * kDimensions), b(a.size());
  std::uint32_t random = 9;
  for (std::size_t i = 0; i < a.size(); i++) a[i] = next_random(&random), b[i] = next_random(&random);
  std::vector<float> expected(kPairs);
  CHECK(datapath->euclidean(a, b, kDimensions, expected));
  std::vector<std::thread> workers;
  std::array<bool, 8> is_equal{};
  for (std::size_t worker = 0; worker < is_equal.size(); worker++) {
    workers.emplace_back([&, worker] {
      bool equal = true;
      for (int round = 0; round < 20; round++) {
        std::vector<float> found(kPairs);
        equal = equal && datapath->euclidean(a, b, kDimensions, found) && found == expected;
        auto pipeline = raypath::Pipeline::create(*datapath);
        for (std::uint64_t tag = 0; tag < 50; tag++) {
          equal = equal && *pipeline->offer(raypath::timing_job(tag % 4), tag);
          const auto result = pipeline->step(true);
          equal = equal && (tag < 12 ? !result : result && result->tag == tag - 12);
        }
        // The message of an error belongs to the thread that made the call.
        const std::string name = "lanes = " + std::to_string(100 + worker);
        const auto wrong = raypath::Datapath::open(name.c_str());
        equal = equal && !wrong && wrong.error().message.find(std::to_string(100 + worker)) != std::string::npos;
      }
      is_equal[worker] = equal;
    });
  }
  for (auto &worker : workers) worker.join();
  for (const bool equal : is_equal) CHECK(equal);
}

int main() {
  errors();
  ownership();
  threads();
  return 0;
}
