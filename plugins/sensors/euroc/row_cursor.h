#pragma once
/// Rows of a text file as a stream in time order, with a bounded look-ahead.
#include <algorithm>
#include <cctype>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "problem_log.h"
#include "row_stream.h"
#include "text_fields.h"
#include "vir/tables/layout.h"

namespace vir::euroc {

/// Why a row is not used.
struct RowFault {
  /// End of the counter's name: "malformed", "before_zero", "not_finite", "implausible".
  std::string kind;
  std::string text;  ///< empty: only counted
};

/// Reads rows of type Row (with a member `TimeNs t`). Rows out of order are sorted as long as they
/// are less than kWindow rows late; later ones, repeated ones and unreadable ones are counted and
/// reported in the log under "<name>_...", and skipped.
template <typename Row>
class RowCursor : public RowStream<Row> {
 public:
  static constexpr std::size_t kWindow = 64;
  using Fields = std::vector<std::string_view>;
  /// Fills the row from the fields; false with the fault filled in when it cannot.
  using Parser = std::function<bool(const Fields&, Row*, RowFault*)>;
  /// Whether two rows of one stamp are the same measurement twice.
  using Same = std::function<bool(const Row&, const Row&)>;

  struct Spec {
    std::string path;
    std::string name;  ///< start of the counters' names: "imu", "image", ...
    Parser parse;
    Same same;
    /// Use a last line without line break: for rows that prove themselves in another way (an image
    /// that exists).
    bool use_open_end = false;
    tables::RowFormat format;
    /// Of further rows that the same line holds.
    std::vector<Parser> also = {};
  };

  /// Throws InputError when the file cannot be opened. `log` must outlive the cursor.
  RowCursor(Spec spec, ProblemLog* log)
      : lines_(spec.path), splitter_(spec.format), spec_(std::move(spec)), log_(log) {
    advance();
  }

  const Row* peek() const override { return has_next_ ? &next_ : nullptr; }
  void pop() override { advance(); }
  std::string where() const override { return lines_.path() + ":" + std::to_string(next_line_); }
  double progress() const override { return lines_.progress(); }
  const std::string& path() const override { return lines_.path(); }
  const std::string& name() const override { return spec_.name; }

 private:
  struct Entry {
    Row row;
    long line;
  };

  void report(const char* kind, long line, const std::string& text) {
    log_->add(spec_.name + "_" + kind, lines_.path() + ":" + std::to_string(line), text);
  }

  /// Reads one row into the window. False at the end of the file.
  bool readOne() {
    std::string line;
    if (!lines_.next(&line)) {
      if (lines_.failed())
        log_->add(spec_.name + "_read_error", lines_.where(), "the file cannot be read further");
      return false;
    }
    splitter_.split(line, &fields_);
    const bool first = !seen_data_;
    seen_data_ = true;
    if (lines_.lastLineOpen() && !spec_.use_open_end) {
      report("cut_line", lines_.lineNumber(),
             "the file ends without a line break: its last line may be cut and is not used");
      return true;
    }
    const char c = fields_.empty() || fields_[0].empty() ? 'x' : fields_[0][0];  // unquoted
    const bool header = first && c != '-' && c != '+' && c != '.' &&
                        std::isdigit(static_cast<unsigned char>(c)) == 0;
    take(spec_.parse, header);
    for (const Parser& parse : spec_.also) take(parse, header);
    return true;
  }

  /// What a parser makes of the line; nothing that it cannot read of a header is a fault.
  void take(const Parser& parse, bool header) {
    Row row;
    RowFault fault;
    if (!parse(fields_, &row, &fault)) {
      if (header) return;
      if (fault.text.empty()) {
        log_->count(spec_.name + "_" + fault.kind);
      } else {
        report(fault.kind.c_str(), lines_.lineNumber(), fault.text);
      }
      return;
    }
    if (row.t < newest_) log_->count(spec_.name + "_out_of_order");
    newest_ = std::max(newest_, row.t);
    window_.emplace(row.t, Entry{std::move(row), lines_.lineNumber()});
  }

  void advance() {
    for (;;) {
      while (!ended_ && window_.size() < kWindow) ended_ = !readOne();
      if (window_.empty()) {
        has_next_ = false;
        return;
      }
      Entry e = std::move(window_.begin()->second);
      window_.erase(window_.begin());
      if (usable(e)) {
        next_ = std::move(e.row);
        next_line_ = e.line;
        has_next_ = true;
        return;
      }
    }
  }

  bool usable(const Entry& e) {
    if (e.row.t < last_t_) {
      report("too_late", e.line, "the stamp lies before rows already passed on; not used");
      return false;
    }
    if (e.row.t > last_t_) at_last_t_.clear();
    for (const Row& other : at_last_t_) {
      if (!spec_.same(other, e.row)) continue;
      report("repeated", e.line,
             "a second row with the stamp " + std::to_string(e.row.t) + "; not used");
      return false;
    }
    last_t_ = e.row.t;
    // A file of one stamp only must not grow the memory.
    if (at_last_t_.size() < kWindow) at_last_t_.push_back(e.row);
    return true;
  }

  LineReader lines_;
  tables::RowSplitter splitter_;
  Spec spec_;
  ProblemLog* log_;
  Fields fields_;
  std::multimap<TimeNs, Entry> window_;
  std::vector<Row> at_last_t_;
  Row next_{};
  long next_line_ = 0;
  TimeNs last_t_ = -1, newest_ = -1;
  bool ended_ = false, has_next_ = false, seen_data_ = false;
};

}  // namespace vir::euroc
