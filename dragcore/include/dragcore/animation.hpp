#pragma once

#include <Eigen/Core>
#include <dragcore/gust.hpp>
#include <dragcore/wind.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace dragcore {

/// How the way from one keyframe to the next is gone, as a function of x in [0, 1].
enum class Easing {
  step,  ///< stays until the next keyframe
  linear,
  smoothstep,    ///< x^2 (3 - 2x): slope 0 at both ends
  cubic_in,      ///< x^3
  cubic_out,     ///< 1 - (1 - x)^3
  cubic_in_out,  ///< 4 x^3, then its mirror image
};

/// 0 at x <= 0, 1 at x >= 1.
double ease(Easing easing, double x);

template <class Value>
struct Keyframe {
  double time = 0.0;  ///< [s] since the animation's beginning, >= 0
  Value value{};
  Easing easing = Easing::linear;  ///< from here to the next keyframe
};

/// Keyframes of a number, a vector, or a rotation (along the shortest arc, so place keyframes less than 180 degrees apart). Constant before
/// the first and after the last.
template <class Value>
class Track {
 public:
  /// @throws std::invalid_argument  when empty, when times are negative or do not increase, when a value is not finite, for a matrix that
  /// is not a rotation
  explicit Track(std::vector<Keyframe<Value>> keyframes);
  Value at(double time) const;
  double duration() const { return keyframes_.back().time; }

 private:
  std::vector<Keyframe<Value>> keyframes_;
};

extern template class Track<double>;
extern template class Track<Eigen::Vector3d>;
extern template class Track<Eigen::Matrix3d>;

/// Changes of a source, all relative to its own placement, so that one animation can play on a whole group.
struct Animation {
  std::optional<Track<Eigen::Vector3d>> position;  ///< displacement, world frame [m]
  std::optional<Track<Eigen::Matrix3d>> rotation;  ///< applied after the source's own, world frame
  std::optional<Eigen::Vector3d> pivot;  ///< point about which `rotation` turns, world frame; the source's own position when left out [m]
  std::optional<Track<Eigen::Vector3d>> scale;                  ///< factors per axis of the field
  std::variant<std::monostate, Track<double>, Gust> intensity;  ///< factor

  double duration() const;  ///< of the longest track [s]
};

enum class Repeat { once, loop, ping_pong };

/// How an animation's clock runs against the clock outside it.
struct Playback {
  double start = 0.0;  ///< before it the first value holds [s]
  double rate = 1.0;   ///< not 0; negative plays from the end
  Repeat repeat = Repeat::once;
  double duration = 0.0;  ///< of one pass on the animation's clock; 0: of its longest track [s]
};

/// Time on the animation's clock, in [0, duration]. Exact remainder, so that a loop is as good after 1e9 s as after one.
double playback_time(const Playback& playback, double natural_duration, double time);

/// An animation played on every source of that name.
struct Cue {
  std::string source;
  Animation animation;
  Playback playback{};
};

/// Cues that start, repeat and run together.
struct AnimationGroup {
  std::vector<Cue> cues;
  Playback playback{};
};

/// Sources and everything that moves them. A pure function of time: scrubbing, replaying and going backwards give the same bits. Cues on
/// the same source act one after another, in order.
class WindController {
 public:
  /// @throws std::invalid_argument  as Wind does; for a cue whose source does not exist (the message lists those that do), a rate of 0, a
  /// group that repeats
  ///                                but has no duration because a cue in it repeats
  explicit WindController(std::vector<WindSource> sources, std::vector<AnimationGroup> groups = {});

  std::vector<WindSource> sources_at(double time) const;
  Wind at(double time) const;  ///< prepared once per instant, then sampled at any number of points
  WindSample sample(const Eigen::Vector3d& point, double time) const { return at(time).sample(point); }

 private:
  std::vector<WindSource> sources_;
  std::vector<AnimationGroup> groups_;
};

}  // namespace dragcore
