// A baked body: a call costs the same whatever was baked. Its error stands beside its time.

#include <dragcore/bake.hpp>

#include "rows.hpp"

namespace dragcore::bench {

void add_baked_rows() {
  for (const std::string body_name : {"cube-12", "ball-2048"})
    for (const std::string way : {"straight", "spinning"}) {
      const std::string name = "baked/" + body_name + "/" + way;
      add_row(name, [=](benchmark::State& state) {
        static std::map<std::string, BakedBody> known;
        const Body& b = body(body_name);
        const Model best = model_for(b.surface);
        if (!known.count(body_name)) known.emplace(body_name, bake(b.surface, best));
        const BakedBody& baked = known.at(body_name);
        const Motion going = motion(way);
        Wrench found;
        for (auto _ : state) benchmark::DoNotOptimize(found = wrench(baked, going, {}));
        state.counters["KiB"] = static_cast<double>(baked.bytes()) / 1024.0;
        state.counters["rms"] = baked.error.rms();
        // One direction may be a few times the rms of all off.
        judge(state, name, found, b.surface, going, 0.05, [&] { return wrench(b.surface, going, {}, best).total(); });
      });
    }
}

}  // namespace dragcore::bench
