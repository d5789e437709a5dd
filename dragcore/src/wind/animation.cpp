#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dragcore/animation.hpp>

#include "support/require.hpp"

namespace dragcore {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

double blend(double a, double b, double x) { return (1.0 - x) * a + x * b; }
Vector3d blend(const Vector3d& a, const Vector3d& b, double x) { return (1.0 - x) * a + x * b; }
Matrix3d blend(const Matrix3d& a, const Matrix3d& b, double x) {
  return Eigen::Quaterniond(a).slerp(x, Eigen::Quaterniond(b)).toRotationMatrix();
}

void check_value(const std::string& what, double value) { require_finite(what, value); }
void check_value(const std::string& what, const Vector3d& value) { require_finite(what, value); }
void check_value(const std::string& what, const Matrix3d& value) {
  require(value.allFinite() && (value.transpose() * value - Matrix3d::Identity()).norm() < 1e-9 && value.determinant() > 0.0,
          what + ": determinant", value.determinant(), "it must be a rotation: columns orthonormal and right-handed");
}

}  // namespace

double ease(Easing easing, double x) {
  if (x >= 1.0) return 1.0;
  if (!(x > 0.0)) return 0.0;
  const double left = 1.0 - x;
  switch (easing) {
    case Easing::step:
      return 0.0;
    case Easing::linear:
      return x;
    case Easing::smoothstep:
      return x * x * (3.0 - 2.0 * x);
    case Easing::cubic_in:
      return x * x * x;
    case Easing::cubic_out:
      return 1.0 - left * left * left;
    case Easing::cubic_in_out:
      return x < 0.5 ? 4.0 * x * x * x : 1.0 - 4.0 * left * left * left;
  }
  return x;
}

template <class Value>
Track<Value>::Track(std::vector<Keyframe<Value>> keyframes) : keyframes_(std::move(keyframes)) {
  require(!keyframes_.empty(), "animation track: number of keyframes", keyframes_.size(), "at least 1 is needed");
  double previous = -1.0;
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    const std::string key = "animation track: keyframe " + std::to_string(i);
    const double time = keyframes_[i].time;
    require(std::isfinite(time) && time >= 0.0 && time > previous, key + ": time", time,
            i == 0 ? "it must be finite and not negative"
                   : "it must be finite and after the one before, " + std::to_string(previous) + " s; use Easing::step for a jump");
    check_value(key + ": value", keyframes_[i].value);
    previous = time;
  }
}

template <class Value>
Value Track<Value>::at(double time) const {
  if (!(time > keyframes_.front().time)) return keyframes_.front().value;
  if (time >= keyframes_.back().time) return keyframes_.back().value;
  const auto next =
      std::upper_bound(keyframes_.begin(), keyframes_.end(), time, [](double t, const Keyframe<Value>& key) { return t < key.time; });
  const Keyframe<Value>& from = *std::prev(next);
  const double x = ease(from.easing, (time - from.time) / (next->time - from.time));
  return x == 0.0 ? from.value : blend(from.value, next->value, x);
}

template class Track<double>;
template class Track<Vector3d>;
template class Track<Matrix3d>;

double Animation::duration() const {
  double longest = 0.0;
  if (position) longest = std::max(longest, position->duration());
  if (rotation) longest = std::max(longest, rotation->duration());
  if (scale) longest = std::max(longest, scale->duration());
  if (const auto* track = std::get_if<Track<double>>(&intensity)) longest = std::max(longest, track->duration());
  if (const auto* gust = std::get_if<Gust>(&intensity)) longest = std::max(longest, gust->start + gust->duration);
  return longest;
}

double playback_time(const Playback& playback, double natural_duration, double time) {
  const double duration = playback.duration > 0.0 ? playback.duration : natural_duration;
  if (!(duration > 0.0)) return 0.0;
  const double elapsed = std::max(0.0, time - playback.start) * std::abs(playback.rate);
  double position = std::min(elapsed, duration);
  if (playback.repeat == Repeat::loop) position = std::fmod(elapsed, duration);
  if (playback.repeat == Repeat::ping_pong) {
    position = std::fmod(elapsed, 2.0 * duration);
    if (position > duration) position = 2.0 * duration - position;
  }
  return playback.rate < 0.0 ? duration - position : position;
}

namespace {

void check(const std::string& what, const Playback& playback) {
  require_finite(what + "start", playback.start);
  require(playback.rate != 0.0 && std::isfinite(playback.rate), what + "rate", playback.rate, "it must be finite and not 0");
  require(playback.duration >= 0.0 && std::isfinite(playback.duration), what + "duration", playback.duration,
          "it must be finite and not negative");
}

/// When the last cue of the group ends, on the group's clock; infinite when one never does.
double natural_duration(const AnimationGroup& group) {
  double longest = 0.0;
  for (const Cue& cue : group.cues) {
    if (cue.playback.repeat != Repeat::once) return std::numeric_limits<double>::infinity();
    const double own = cue.playback.duration > 0.0 ? cue.playback.duration : cue.animation.duration();
    longest = std::max(longest, cue.playback.start + own / std::abs(cue.playback.rate));
  }
  return longest;
}

void apply(const Animation& animation, double time, WindSource& source) {
  Placement& placement = source.placement;
  if (animation.rotation) {
    const Matrix3d turn = animation.rotation->at(time);
    placement.rotation = turn * placement.rotation;
    if (animation.pivot) placement.position = *animation.pivot + turn * (placement.position - *animation.pivot);
  }
  if (animation.position) placement.position += animation.position->at(time);
  if (animation.scale) placement.scale = placement.scale.cwiseProduct(animation.scale->at(time));
  if (const auto* track = std::get_if<Track<double>>(&animation.intensity)) source.intensity *= track->at(time);
  if (const auto* gust = std::get_if<Gust>(&animation.intensity)) source.intensity *= gust_factor(*gust, time);
}

}  // namespace

WindController::WindController(std::vector<WindSource> sources, std::vector<AnimationGroup> groups)
    : sources_(std::move(sources)), groups_(std::move(groups)) {
  Wind check_sources(sources_);
  std::string names;
  for (const WindSource& source : sources_) names += (names.empty() ? "'" : ", '") + source.name + "'";
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const std::string group_name = "animation group " + std::to_string(g) + ": ";
    check(group_name, groups_[g].playback);
    require(groups_[g].playback.repeat == Repeat::once || groups_[g].playback.duration > 0.0 || std::isfinite(natural_duration(groups_[g])),
            group_name + "duration", groups_[g].playback.duration, "it must be given because the group repeats and a cue in it never ends");
    for (const Cue& cue : groups_[g].cues) {
      const std::string name = group_name + "cue on '" + cue.source + "': ";
      require(std::any_of(sources_.begin(), sources_.end(), [&](const WindSource& source) { return source.name == cue.source; }),
              name + "source", cue.source, names.empty() ? "there is no source at all" : "the sources are " + names);
      check(name, cue.playback);
      if (cue.animation.pivot) require_finite(name + "pivot", *cue.animation.pivot);
      if (const auto* gust = std::get_if<Gust>(&cue.animation.intensity)) {
        validate(*gust);
        require(gust->start >= 0.0, name + "start of the gust", gust->start,
                "an animation's clock begins at 0 s; shift the playback instead");
      }
    }
  }
}

std::vector<WindSource> WindController::sources_at(double time) const {
  require_finite("wind controller: time", time);
  std::vector<WindSource> moved = sources_;
  for (const AnimationGroup& group : groups_) {
    const double group_time = playback_time(group.playback, natural_duration(group), time);
    for (const Cue& cue : group.cues) {
      const double cue_time = playback_time(cue.playback, cue.animation.duration(), group_time);
      for (WindSource& source : moved)
        if (source.name == cue.source) apply(cue.animation, cue_time, source);
    }
  }
  return moved;
}

Wind WindController::at(double time) const { return Wind(sources_at(time), time); }

}  // namespace dragcore
