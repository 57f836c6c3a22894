#include "term_layout.h"

#include <ceres/cost_function.h>

#include <algorithm>
#include <functional>
#include <type_traits>
#include <typeinfo>

#include "vir/factors/linear_prior_factor.h"
#include "vir/factors/reprojection_factor.h"

namespace vir::window {
namespace {

constexpr int kNone = -1;

TermShape shapeOf(const Term& t) {
  const std::type_info& type = typeid(*t.cost);
  if (!t.landmark) {
    const bool prior = t.robust <= 0 && type == typeid(factors::LinearPriorFactor);
    return prior ? TermShape::prior : TermShape::dense;
  }
  if (type == typeid(factors::ReprojectionFactor)) return TermShape::sight;
  if (type == typeid(factors::ReprojectionCalibrationFactor)) return TermShape::calibrated_sight;
  if (type == typeid(factors::RigReprojectionFactor)) {
    const auto& f = static_cast<const factors::RigReprojectionFactor&>(*t.cost);
    if (f.calibrated()) return f.sameFrame() ? TermShape::rig_pair : TermShape::rig_sight;
  }
  return TermShape::any_of_landmark;
}

template <typename Factor>
TermLayout::Pair pairOf(const Term& t) {
  const auto& f = static_cast<const Factor&>(*t.cost);
  TermLayout::Pair out;
  out.pose_i = t.blocks[0];
  out.pose_j = t.blocks[1];
  out.lin_i = f.linI();
  out.lin_j = f.linJ();
  if constexpr (std::is_same_v<Factor, factors::ReprojectionFactor>) {
    out.T_B_C = f.extrinsics();
  } else {
    out.extrinsic = t.blocks[2];
  }
  return out;
}

bool alike(const TermLayout::Pair& a, const TermLayout::Pair& b) {
  return a.lin_i == b.lin_i && a.lin_j == b.lin_j && a.extrinsic == b.extrinsic &&
         a.extrinsic_j == b.extrinsic_j && a.T_B_C.p == b.T_B_C.p &&
         a.T_B_C.q.coeffs() == b.T_B_C.q.coeffs();
}

}  // namespace

void TermLayout::build(const std::vector<Term>& terms, const std::vector<BlockRef>& order) {
  blocks_.clear();
  by_address_.clear();
  block_at_.clear();
  size_ = 0;
  for (BlockRef b : order) {
    b.offset = size_;
    size_ += b.local();
    block_at_.resize(static_cast<std::size_t>(size_), static_cast<int>(blocks_.size()));
    by_address_.emplace_back(b.data, b.offset);
    blocks_.push_back(b);
  }
  std::sort(by_address_.begin(), by_address_.end(), [](const auto& a, const auto& b) {
    return std::less<const double*>()(a.first, b.first);
  });
  entries_.clear();
  columns_.clear();
  slot_of_.clear();
  landmarks_.clear();
  slots_.clear();
  last_.clear();
  pairs_.clear();
  rig_pairs_.clear();
  pair_table_.assign(blocks_.size() * blocks_.size(), kNone);
  for (const Term& t : terms) {
    const bool open = !landmarks_.empty() && landmarks_.back().slots == kNone;
    if (open && landmarks_.back().x != t.landmark) closeLandmark();
    if (t.landmark && (landmarks_.empty() || landmarks_.back().x != t.landmark)) {
      LandmarkTerms l;
      l.x = t.landmark;
      l.first_entry = static_cast<int>(entries_.size());
      l.first_slot = static_cast<int>(slots_.size());
      l.slots = kNone;
      landmarks_.push_back(l);
    }
    addEntry(t);
  }
  if (!landmarks_.empty() && landmarks_.back().slots == kNone) closeLandmark();
}

int TermLayout::columnOf(const double* block, std::size_t position) {
  // Neighbouring terms share most of their blocks.
  if (position < last_.size() && last_[position].first == block) return last_[position].second;
  const auto at = std::lower_bound(by_address_.begin(), by_address_.end(), block,
                                   [](const auto& entry, const double* x) {
                                     return std::less<const double*>()(entry.first, x);
                                   });
  const int column = at != by_address_.end() && at->first == block ? at->second : kConstant;
  if (last_.size() <= position) last_.resize(position + 1, {nullptr, kConstant});
  last_[position] = {block, column};
  return column;
}

void TermLayout::addEntry(const Term& t) {
  Entry e;
  e.term = &t;
  e.shape = shapeOf(t);
  e.first = static_cast<int>(columns_.size());
  e.blocks = static_cast<int>(t.blocks.size());
  bool constant = false;
  for (std::size_t k = 0; k < t.blocks.size(); ++k) {
    const int column =
        t.landmark && t.blocks[k] == t.landmark ? kLandmark : columnOf(t.blocks[k], k);
    columns_.push_back(column);
    constant = constant || column == kConstant;
    slot_of_.push_back(kNone);
  }
  const bool sight = e.shape == TermShape::sight || e.shape == TermShape::calibrated_sight;
  // These are worth a way of their own where everything is as it always is: host before the other
  // frame, calibration behind both.
  bool usual = sight && !constant && columnOf(e, 0) < columnOf(e, 1);
  if (usual && e.shape == TermShape::calibrated_sight) {
    usual = columnOf(e, 1) < columnOf(e, 2) && columnOf(e, 2) < columnOf(e, 4);
  }
  const bool rig = e.shape == TermShape::rig_sight || e.shape == TermShape::rig_pair;
  if (sight && !(usual && findPair(&e))) e.shape = TermShape::any_of_landmark;
  if (rig && (constant || !findRigPair(&e))) e.shape = TermShape::any_of_landmark;
  entries_.push_back(e);
}

bool TermLayout::findPair(Entry* e) {
  const Pair pair = e->shape == TermShape::sight
                        ? pairOf<factors::ReprojectionFactor>(*e->term)
                        : pairOf<factors::ReprojectionCalibrationFactor>(*e->term);
  const auto block = [&](int k) {
    return static_cast<std::size_t>(block_at_[static_cast<std::size_t>(columnOf(*e, k))]);
  };
  int& at = pair_table_[block(0) * blocks_.size() + block(1)];
  if (at == kNone) {
    at = static_cast<int>(pairs_.size());
    pairs_.push_back(pair);
  }
  e->pair = at;
  return alike(pairs_[static_cast<std::size_t>(at)], pair);
}

bool TermLayout::findRigPair(Entry* e) {
  const auto& f = static_cast<const factors::RigReprojectionFactor&>(*e->term->cost);
  const BlockList& blocks = e->term->blocks;
  const bool same = e->shape == TermShape::rig_pair;
  const int first = same ? 1 : 3;  // block of the calibration
  Pair pair;
  std::array<int, 4> key{kConstant, kConstant, columnOf(*e, first), columnOf(*e, first + 2)};
  if (!same) {
    pair.pose_i = blocks[1];
    pair.pose_j = blocks[2];
    pair.lin_i = f.linI();
    pair.lin_j = f.linJ();
    key[0] = columnOf(*e, 1);
    key[1] = columnOf(*e, 2);
  }
  pair.extrinsic = blocks[static_cast<std::size_t>(first)];
  pair.extrinsic_j = blocks[static_cast<std::size_t>(first) + 2];
  const auto [at, added] = rig_pairs_.emplace(key, static_cast<int>(pairs_.size()));
  if (added) pairs_.push_back(pair);
  e->pair = at->second;
  return alike(pairs_[static_cast<std::size_t>(e->pair)], pair);
}

void TermLayout::closeLandmark() {
  LandmarkTerms& l = landmarks_.back();
  l.entries = static_cast<int>(entries_.size()) - l.first_entry;
  const auto first = static_cast<std::ptrdiff_t>(slots_.size());
  const auto offset_of = [](const Slot& s) { return s.offset; };
  for (int k = l.first_entry; k < l.first_entry + l.entries; ++k) {
    const Entry& e = entries_[static_cast<std::size_t>(k)];
    const std::vector<int>& sizes = e.term->cost->parameter_block_sizes();
    for (int b = 0; b < e.blocks; ++b) {
      const int column = columnOf(e, b);
      if (column < 0) continue;
      const bool known = std::any_of(slots_.begin() + first, slots_.end(),
                                     [&](const Slot& s) { return offset_of(s) == column; });
      if (known) continue;
      const int ambient = sizes[static_cast<std::size_t>(b)];
      slots_.push_back({column, ambient == 7 ? 6 : ambient});
    }
  }
  std::sort(slots_.begin() + first, slots_.end(),
            [](const Slot& a, const Slot& b) { return a.offset < b.offset; });
  l.slots = static_cast<int>(slots_.size()) - l.first_slot;
  for (int k = l.first_entry; k < l.first_entry + l.entries; ++k) {
    const Entry& e = entries_[static_cast<std::size_t>(k)];
    for (int b = 0; b < e.blocks; ++b) {
      const int column = columnOf(e, b);
      if (column < 0) continue;
      int at = l.first_slot;
      while (slots_[static_cast<std::size_t>(at)].offset != column) ++at;
      slot_of_[static_cast<std::size_t>(e.first + b)] = at;
    }
  }
}

}  // namespace vir::window
