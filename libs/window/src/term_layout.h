#pragma once
/// Internal: where the blocks of terms stand in the normal equations. Worked out once for as many
/// linearisations as a solution takes.
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "vir/geometry/pose.h"
#include "vir/window/marginalization.h"

namespace vir::window {

/// What a term is made of, as far as its linearisation can make use of it.
enum class TermShape {
  dense,             ///< no landmark
  prior,             ///< a LinearPriorFactor without a robust loss
  sight,             ///< a ReprojectionFactor
  calibrated_sight,  ///< a ReprojectionCalibrationFactor
  rig_sight,         ///< a RigReprojectionFactor between two frames, the calibration estimated
  rig_pair,          ///< likewise within one frame
  any_of_landmark
};

class TermLayout {
 public:
  static constexpr int kConstant = -1;  ///< column of a block that is held
  static constexpr int kLandmark = -2;  ///< column of a landmark

  struct Entry {
    const Term* term = nullptr;
    TermShape shape = TermShape::dense;
    int first = 0;  ///< its first block in columnOf() and slotOf()
    int blocks = 0;
    int pair = -1;  ///< of a sight, in pairs()
  };
  /// The two frames of a sight, and where its Jacobians are taken.
  struct Pair {
    const double *pose_i = nullptr, *pose_j = nullptr;  ///< nullptr: of one frame
    const double *lin_i = nullptr, *lin_j = nullptr;    ///< nullptr: at the current value
    const double* extrinsic = nullptr;                  ///< nullptr: `T_B_C`
    const double* extrinsic_j = nullptr;                ///< nullptr: it is the same camera
    Pose T_B_C;
    bool linearizedElsewhere() const { return lin_i || lin_j; }
  };
  /// A block that the terms of one landmark touch.
  struct Slot {
    int offset = 0, size = 0;
  };
  struct LandmarkTerms {
    double* x = nullptr;
    int first_entry = 0, entries = 0;
    int first_slot = 0, slots = 0;  ///< by ascending offset
  };

  /// `order`: the blocks that remain, one behind the other; blocks that are neither there nor a
  /// landmark are constant. Terms of one landmark must be adjacent. Keeps pointers to the terms.
  void build(const std::vector<Term>& terms, const std::vector<BlockRef>& order);

  const std::vector<BlockRef>& blocks() const { return blocks_; }
  int size() const { return size_; }
  const std::vector<Entry>& entries() const { return entries_; }
  const std::vector<LandmarkTerms>& landmarks() const { return landmarks_; }
  const std::vector<Pair>& pairs() const { return pairs_; }
  const Slot& slot(int k) const { return slots_[static_cast<std::size_t>(k)]; }
  int slots() const { return static_cast<int>(slots_.size()); }
  int columnOf(const Entry& e, int block) const {
    return columns_[static_cast<std::size_t>(e.first + block)];
  }
  /// Slot of a block of a landmark's term; only of blocks that have a column.
  int slotOf(const Entry& e, int block) const {
    return slot_of_[static_cast<std::size_t>(e.first + block)];
  }

 private:
  int columnOf(const double* block, std::size_t position);
  void addEntry(const Term& t);
  /// False if a sight of these frames has been seen that is not alike.
  bool findPair(Entry* e);
  /// Likewise of a sight of another camera than the host's.
  bool findRigPair(Entry* e);
  void closeLandmark();

  std::vector<BlockRef> blocks_;
  int size_ = 0;
  std::vector<Entry> entries_;
  std::vector<int> columns_, slot_of_;
  std::vector<Pair> pairs_;
  std::vector<int> block_at_;    ///< index of the block that begins at a column
  std::vector<int> pair_table_;  ///< by both frames' blocks; -1: none yet
  /// By the columns of both poses (kConstant: of one frame) and both extrinsics.
  std::map<std::array<int, 4>, int> rig_pairs_;
  std::vector<LandmarkTerms> landmarks_;
  std::vector<Slot> slots_;
  std::vector<std::pair<const double*, int>> by_address_;  // looked up only
  std::vector<std::pair<const double*, int>> last_;        // by position in the term
};

}  // namespace vir::window
