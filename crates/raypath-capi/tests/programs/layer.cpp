// The C++ layer: ownership, spans, errors as values, and threads that share a datapath and a unit.

#include <raypath.hpp>

#include "check.h"

#include <array>
#include <cmath>
#include <cstring>
#include <thread>
#include <vector>

static_assert(sizeof(raypath::Ray) == 64 && sizeof(raypath::Box) == 24 && sizeof(raypath::Vertices) == 36);
static_assert(sizeof(raypath::QuadboxResult) == 24 && sizeof(raypath::TriangleResult) == 12);
static_assert(!std::is_copy_constructible_v<raypath::Datapath> && !std::is_copy_constructible_v<raypath::Pipeline>);
static_assert(std::is_nothrow_move_constructible_v<raypath::Datapath>);
static_assert(sizeof(raypath::UnitRay) == 48 && sizeof(raypath::UnitHit) == 56);
static_assert(!std::is_copy_constructible_v<raypath::Unit> && !std::is_copy_constructible_v<raypath::UnitModel>);

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
  const auto state = other.save();
  auto copy = other.clone(), restored = raypath::Pipeline::create(moved);
  CHECK(copy && restored && restored->restore(state) && copy->save() == state && restored->save() == state);
  CHECK(copy->skip(100) == 12 && restored->skip(100) == 12 && restored->step(true)->tag == 42);
  CHECK(!restored->restore({state.data(), state.size() - 1}) && !restored->restore({}) && restored->occupancy() == 0);
  CHECK(other.skip(100) == 12 && other.output_valid() && other.occupancy() == 1);
  const auto result = other.step(true);
  CHECK(result && result->tag == 42 && result->output.quadbox.tmin[3] == 6.0f);
  CHECK(!other.step(true));
  CHECK(*other.offer(raypath::triangle_job(*ray, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), 1));
  CHECK(!other.offer(raypath::timing_job(9), 2));
  other.reset();
  CHECK(other.occupancy() == 0 && other.input_ready(1));
}

// A leaf of one triangle at address 0, as docs/reference/unit.md has it: nine numbers, then its index at byte 112.
static std::array<std::uint8_t, 128> one_triangle() {
  std::array<std::uint8_t, 128> block{};
  const float vertices[9] = {-1, -1, 3, 1, -1, 3, 0, 1, 3};
  const std::uint32_t index = 5;
  std::memcpy(block.data(), vertices, sizeof vertices);
  std::memcpy(block.data() + 112, &index, sizeof index);
  return block;
}

// A ray through the functional and through the cycle-exact model, with a memory that answers in the next cycle.
static void traversal() {
  CHECK(raypath::Unit::open("contexts = 7").error().status == RAYPATH_ERROR_CONFIGURATION);
  auto opened = raypath::Unit::open("preset = \"compact\"\ncontexts = 8\nmemory-width = 512");
  CHECK(opened && opened->parameters().contexts == 8 && opened->parameters().memory_width == 512);
  CHECK(std::string(opened->description()).find("8 contexts") != std::string::npos);
  const raypath::Unit unit = std::move(*opened);
  const auto scene = one_triangle();
  std::array<raypath::UnitRay, 1> rays{};
  std::array<raypath::UnitHit, 1> hits{};
  rays[0].direction[2] = 2.0f;
  rays[0].t_max = INFINITY;
  rays[0].root = 1;  // a leaf of one triangle at address 0
  CHECK(unit.trace(scene, rays, hits));
  // The back face at z = 3, in units of a direction of length 2.
  CHECK(hits[0].status == RAYPATH_UNIT_HIT && hits[0].primitive == 5 && hits[0].t == 1.5f && hits[0].back_face == 1);
  CHECK(hits[0].instance == RAYPATH_UNIT_NO_INSTANCE);
  CHECK(unit.trace(scene, rays, {}).error().status == RAYPATH_ERROR_ARGUMENT);
  CHECK(!unit.generate("/dev/null/x"));

  // The same triangle as a scene that raypath builds: the same hit, but for its index.
  const float vertices[][3] = {{-1, -1, 3}, {1, -1, 3}, {0, 1, 3}};
  const std::uint32_t triangles[][3] = {{0, 1, 2}};
  const auto built = raypath::Scene::build(unit, vertices, triangles);
  CHECK(built && built->bytes().size() == 256 && std::isinf(built->reach()));
  std::array<raypath::UnitRay, 1> again = rays;
  again[0].root = built->root();
  std::array<raypath::UnitHit, 1> found{};
  CHECK(unit.trace(built->bytes(), again, found) && found[0].primitive == 0 && found[0].t == 1.5f);
  const std::uint32_t wrong[][3] = {{0, 1, 3}};
  CHECK(raypath::Scene::build(unit, vertices, wrong).error().message.find("names vertex 3") != std::string::npos);
  raypath::Scene::Instance place[1] = {{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 5}}, 0, 255, 0, 0}};
  CHECK(raypath::Scene::build(unit, vertices, triangles, place).error().status == RAYPATH_ERROR_ARGUMENT);
  const auto two_levels = raypath::Unit::open("instances = true");
  const auto placed = raypath::Scene::build(*two_levels, vertices, triangles, place, 100.0f);
  CHECK(placed && placed->reach() == 100.0f);
  again[0].root = placed->root();
  CHECK(two_levels->trace(placed->bytes(), again, found) && found[0].t == 4.0f && found[0].instance == 0);
  const raypath::Scene *const members[] = {&*placed};
  const std::uint32_t member[] = {0};
  CHECK(raypath::Scene::group(*two_levels, members, member, place).error().status == RAYPATH_ERROR_ARGUMENT);
  const auto nested = raypath::Unit::open("instances = true\nnested-instances = true");
  const auto far_reaching = raypath::Scene::build(*nested, vertices, triangles, place, 1000.0f);
  const raypath::Scene *const deep[] = {&*far_reaching};
  const auto group = raypath::Scene::group(*nested, deep, member, place);
  CHECK(nested && group);
  again[0].root = group->root();
  CHECK(nested->trace(group->bytes(), again, found) && found[0].status == RAYPATH_UNIT_HIT && found[0].t == 6.5f);

  // With queries: masks, indices, and geometries that are opaque or not.
  const raypath::Scene::Geometry geometries[] = {{1, 0, 1}};
  place[0].mask = 2, place[0].custom_index = 77, place[0].shader_offset = 5;
  CHECK(raypath::Scene::build(*two_levels, vertices, triangles, place).error().message.find("queries none") !=
        std::string::npos);
  const auto queries = raypath::Unit::open("instances = true\nqueries = \"flags\"");
  const auto masked = raypath::Scene::build(*queries, vertices, triangles, place, 100.0f, geometries);
  again[0].root = masked->root(), again[0].cull_mask = 1;
  CHECK(queries->trace(masked->bytes(), again, found) && found[0].status == RAYPATH_UNIT_MISS);
  again[0].cull_mask = 3;
  CHECK(queries->trace(masked->bytes(), again, found) && found[0].status == RAYPATH_UNIT_HIT);
  CHECK(found[0].custom_index == 77 && found[0].shader_offset == 5 && found[0].geometry == 0);
  again[0].flags = RAYPATH_RAY_CULL_NO_OPAQUE;
  CHECK(queries->trace(masked->bytes(), again, found) && found[0].status == RAYPATH_UNIT_MISS);
  again[0].flags = RAYPATH_RAY_OPAQUE | RAYPATH_RAY_NO_OPAQUE;
  CHECK(queries->trace(masked->bytes(), again, found) && found[0].status == RAYPATH_UNIT_REFUSED);
  again[0].flags = 0;

  // Candidates: a triangle that is not opaque before a procedural box, which is hit where the caller says.
  const raypath::Box boxes[] = {{{-1, -1, 8}, {1, 1, 10}}};
  const raypath::Scene::Geometry both[] = {{1, 0, 1}, {0, 1, 0}};
  const auto asking = raypath::Unit::open("queries = \"full\"");
  CHECK(raypath::Scene::build(*queries, vertices, triangles, {}, 100.0f, both, boxes).error().message.find(
            "expected full") != std::string::npos);
  const auto mixed = raypath::Scene::build(*asking, vertices, triangles, {}, 100.0f, both, boxes);
  again[0].root = mixed->root(), again[0].flags = 0;
  int asked = 0;
  auto query = raypath::Query::create(*asking, again[0]);
  CHECK(!query->hit());
  while (query->proceed(mixed->bytes())) {
    CHECK(query->candidate().is_box == (asked == 1) && query->candidate().geometry == (asked == 1));
    CHECK(std::memcmp(query->candidate().origin, again[0].origin, sizeof again[0].origin) == 0);
    CHECK(std::memcmp(query->candidate().direction, again[0].direction, sizeof again[0].direction) == 0);
    if (query->candidate().is_box) query->generate(4.25f);
    asked++;
  }
  CHECK(asked == 2 && query->hit()->status == RAYPATH_UNIT_PROCEDURAL && query->hit()->t == 4.25f);
  query = raypath::Query::create(*asking, again[0]);
  CHECK(query->proceed(mixed->bytes()));
  query->confirm();
  query->terminate();
  CHECK(!query->proceed(mixed->bytes()) && query->hit()->status == RAYPATH_UNIT_HIT && query->hit()->t == 1.5f);
  asked = 0;
  const auto ignore = [](void *user, const raypath_unit_candidate *, raypath_unit_verdict *) { ++*static_cast<int *>(user); };
  CHECK(raypath_unit_trace_with(asking->get(), mixed->bytes().data(), mixed->bytes().size(), again.data(), 1, found.data(),
                                ignore, &asked) == RAYPATH_OK);
  CHECK(asked == 2 && found[0].status == RAYPATH_UNIT_MISS);
  CHECK(asking->trace(mixed->bytes(), again, found) && found[0].status == RAYPATH_UNIT_HIT);

  auto model = raypath::UnitModel::create(unit);
  CHECK(model && model->outputs().ray_ready == 1);
  raypath::UnitInputs inputs{};
  inputs.ray = rays[0];
  inputs.ray_id = 42;
  inputs.ray_valid = 1;
  CHECK(model->step(inputs));
  inputs = {};
  std::uint64_t cycles = 0;
  while (!model->outputs().mem_req_valid) cycles += model->skip(1000);
  CHECK(cycles == 22);  // its first request is in cycle 23, as docs/reference/unit.md states
  CHECK(model->outputs().mem_req_valid == 1 && model->outputs().mem_req_addr == 0);
  inputs.mem_rsp_tag = model->outputs().mem_req_tag;
  inputs.mem_req_ready = 1;
  CHECK(model->step(inputs));
  inputs.mem_rsp_valid = 1;
  for (std::size_t beat = 0; beat < 2; beat++) {
    inputs.mem_rsp_data = scene.data() + 64 * beat;
    CHECK(model->step(inputs));
  }
  CHECK(!model->step(inputs));  // the block is complete
  auto copy = model->clone(), restored = raypath::UnitModel::create(unit);
  CHECK(copy && restored && restored->restore(model->save()) && copy->save() == model->save());
  for (auto *one : {&*model, &*copy, &*restored})
    while (!one->outputs().hit_valid) one->skip(1000);
  CHECK(copy->counts().cycles == model->counts().cycles && restored->save() == model->save());
  const auto outputs = model->outputs();
  CHECK(outputs.hit_valid == 1 && outputs.hit_id == 42);
  CHECK(std::memcmp(&outputs.hit, &hits[0], sizeof hits[0]) == 0);
  CHECK(model->counts().triangles == 1 && model->counts().rays == 1);
  model->reset();
  CHECK(model->outputs().hit_valid == 0 && model->counts().cycles == 0);
}

// Threads share a datapath, each with a pipeline of its own, and have the results of one thread.
static void threads() {
  const auto datapath = raypath::Datapath::open();
  const auto unit = raypath::Unit::open();
  const auto scene = one_triangle();
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
        raypath::UnitRay ray{};
        raypath::UnitHit hit{};
        ray.direction[2] = 1.0f, ray.t_max = 10.0f, ray.root = 1;
        equal = equal && unit->trace(scene, {&ray, 1}, {&hit, 1}) && hit.t == 3.0f;
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
  traversal();
  threads();
  return 0;
}
