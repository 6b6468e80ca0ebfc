// Stretches of a trajectory that are not its marker's. Internal to repair.
#pragma once

#include <map>
#include <vector>

#include "capture/repair.h"
#include "capture/repair/local_motion.h"

namespace kinemesh::repair {

/// A trajectory breaks (it comes back from a gap, or jumps within a frame), goes on elsewhere than
/// its neighbours carry the marker, breaks again and then goes on where they do.
class StrayFinder {
 public:
  StrayFinder(LocalMotion motion, double rate_hz);
  /// Markers as in the motion.
  std::vector<Stray> run(const RunContext& ctx);

 private:
  enum class Break : uint8_t { none, gap, jump };
  struct Stretch {
    std::size_t marker = 0;
    FrameRange frames;
    bool open = false;   ///< it lasts to the take's begin or end: nothing confirms it
    bool clear = false;  ///< so far off that it goes even when it is nobody's
    std::size_t owner = MarkerSequence::npos;  ///< where another one takes it over
    std::vector<double> off;                   ///< by frame, mm; negative where it was not seen
  };

  void scan(std::size_t m);
  Break break_at(std::size_t m, std::size_t g, std::size_t f) const;
  /// From frame `f`, seen from its last own sample `base`, onwards (`way` 1) or backwards (−1).
  bool follow(std::size_t m, std::size_t base, std::size_t f, int way, Break first, Stretch& out);
  bool handed_over(std::size_t m, std::size_t f, double away);
  std::size_t last_sight(std::size_t m, std::size_t f) const;
  void take_out(const Stretch& stretch);
  void put_back(const Stretch& stretch);
  /// Distance of the marker in frame `f` from where its sample in frame `from` leads.
  double off(std::size_t m, std::size_t from, std::size_t f) const;
  /// Where samples on both sides lead, the nearer the heavier.
  Eigen::Vector3d between(std::size_t m, std::size_t before, std::size_t behind,
                          std::size_t f) const;
  /// What the distance must exceed to be no motion: twice what 95 % of the take's own stretches of
  /// that length keep, from one side or in the middle between two, and what makes a jump; frames
  /// `without` are not asked.
  double limit(std::size_t m, std::size_t length, bool bridged, const FrameRange& without) const;
  /// The same from one side, rounded up to a power of two and kept.
  double limit(std::size_t m, std::size_t frames);
  bool finish(std::size_t base, std::size_t home, std::size_t f, std::size_t last, Stretch& out);
  std::size_t owner(const Stretch& stretch, std::size_t f, std::vector<std::size_t>& taken);
  std::vector<Stray> share_out(const Stretch& stretch);

  LocalMotion motion_;
  LocalMotion recorded_;
  std::size_t wait_ = 0;
  std::vector<double> least_jump_;
  std::map<std::pair<std::size_t, std::size_t>, double> limits_;
  std::vector<Stretch> stretches_;
  std::vector<std::vector<std::size_t>> owned_;  ///< by frame: markers that got a sample
};

}  // namespace kinemesh::repair
