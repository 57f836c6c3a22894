#pragma once
/// Rows of one kind in time order, wherever they come from.
#include <string>
#include <utility>
#include <vector>

namespace vir::euroc {

template <typename Row>
class RowStream {
 public:
  virtual ~RowStream() = default;
  /// The next row, or nullptr at the end.
  virtual const Row* peek() const = 0;
  virtual void pop() = 0;
  /// File and line of peek()'s row.
  virtual std::string where() const = 0;
  virtual double progress() const = 0;  ///< 0..1
  virtual const std::string& path() const = 0;
  /// Start of its counters' names in the log: "imu", "image", ...
  virtual const std::string& name() const = 0;
};

/// Rows that are in memory, in time order.
template <typename Row>
class ListedRows : public RowStream<Row> {
 public:
  ListedRows(std::string path, std::string name, std::vector<Row> rows)
      : path_(std::move(path)), name_(std::move(name)), rows_(std::move(rows)) {}
  const Row* peek() const override { return next_ < rows_.size() ? &rows_[next_] : nullptr; }
  void pop() override { ++next_; }
  std::string where() const override { return path_ + ", image " + std::to_string(next_ + 1); }
  double progress() const override {
    return rows_.empty() ? 1 : static_cast<double>(next_) / static_cast<double>(rows_.size());
  }
  const std::string& path() const override { return path_; }
  const std::string& name() const override { return name_; }

 private:
  std::string path_, name_;
  std::vector<Row> rows_;
  std::size_t next_ = 0;
};

}  // namespace vir::euroc
