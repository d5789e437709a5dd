// A baked body: a call costs the same whatever was baked. Its error stands beside its time. By itself, and 1024 motions of it at once.

#include <dragcore/bake.hpp>

#include "rows.hpp"

namespace dragcore::bench {

namespace {

const BakedBody& baked(const std::string& body_name) {
  static std::map<std::string, BakedBody> known;
  if (!known.count(body_name)) known.emplace(body_name, bake(body(body_name).surface, model_for(body(body_name).surface)));
  return known.at(body_name);
}

/// One direction may be a few times the rms of all off.
constexpr double tolerance = 0.05;

}  // namespace

void add_baked_rows() {
  for (const std::string body_name : {"cube-12", "ball-2048"})
    for (const std::string way : {"straight", "spinning"})
      for (const bool many : {false, true}) {
        const std::string name = "baked/" + body_name + "/" + way + (many ? "/batch" : "");
        add_row(name, [=](benchmark::State& state) {
          const BakedBody& map = baked(body_name);
          const Body& b = body(body_name);
          const Motion going = motion(way);
          const std::vector<Motion> motions(many ? 1024 : 1, going);
          std::vector<Wrench> found(motions.size());
          for (auto _ : state) {
            if (many)
              wrenches(map, motions, {}, found);
            else
              benchmark::DoNotOptimize(found[0] = wrench(map, going, {}));
          }
          count(state, static_cast<double>(motions.size()), "per_body");
          state.counters["KiB"] = static_cast<double>(map.bytes()) / 1024.0;
          state.counters["rms"] = map.error.rms();
          judge(state, name, found.back(), b.surface, going, tolerance,
                [&] { return wrench(b.surface, going, {}, model_for(b.surface)).total(); });
        });
      }
}

}  // namespace dragcore::bench
