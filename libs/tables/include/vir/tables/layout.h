#pragma once
/// How a text file of numbers is laid out: separator, header, columns by name, unit of the stamps.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vir/tables/row_format.h"
#include "vir/tables/stamps.h"

namespace vir::tables {

/// A column's name as written in a header, without its unit, in lower case, other characters than
/// letters and digits as '_': `w_RS_S_x [rad s^-1]` is `w_rs_s_x`. A `field.` in front, of
/// `rostopic echo -p`, is no part of it. What is in the brackets is kept
/// where it is a place, not a unit: `gyro_rad[0]` is `gyro_rad_0`.
std::string plainName(std::string_view name);

struct Layout : RowFormat {
  /// Plain names in the order of the columns; empty without a header.
  std::vector<std::string> names;
  /// The names without a unit behind them or a device in front (`imu_acc_x_mg`: `acc_x`); same
  /// length.
  std::vector<std::string> bare;
  std::vector<std::string> units;  ///< in brackets behind the names, as written; same length
  /// The names as written, without what is in brackets; same length.
  std::vector<std::string> written;
  char header_separator = ',';  ///< between the names
  std::size_t columns = 0;      ///< of the rows of data
  /// Fields of the first rows of data, at most kSampled, as RowSplitter gives them.
  std::vector<std::vector<std::string>> rows;
  /// Single rows from all over the rest.
  std::vector<std::vector<std::string>> later;
  static constexpr std::size_t kSampled = 200;

  /// The first column of one of these (plain) names, or -1.
  int find(const std::vector<std::string>& names) const;
  /// The values of a column in the sampled rows.
  std::vector<std::string> column(std::size_t index) const;
};

/// Reads the beginning of a file; one that is not there has no columns. `#` and `%` begin comments;
/// the last comment before the data, or a first line that begins with no number, is the header.
Layout layoutOf(const std::string& path);
/// The same of text.
Layout layoutOfText(std::string_view text);

/// Where a kind of row has what; -1: not there.
struct PoseColumns {
  int stamp = 0;
  int p[3] = {1, 2, 3};
  int q[4] = {-1, -1, -1, -1};   ///< x y z w
  int angles[3] = {-1, -1, -1};  ///< roll pitch yaw, where there is no quaternion
  double angle_unit = 1;         ///< [rad] of what the angles are in
  bool named = false;            ///< the header said so
  double unit_m = 1;             ///< of what the header says the positions are in
  bool down = false;             ///< positions are east, north, down: eastNorthUp() turns them
  std::string remark;            ///< what is to be said of the attitudes; may be empty
  bool hasAttitude() const { return q[3] >= 0 || hasAngles(); }
  bool hasAngles() const { return angles[2] >= 0; }
  int last() const;
};
/// By the names of the header (q0 q1 q2 q3 have w first), else TUM's order (t x y z qx qy qz qw)
/// where there are only blanks or the stamps are seconds, and EuRoC's (t x y z qw qx qy qz)
/// elsewhere. A first column that only counts is passed over. Roll, pitch and yaw are those of
/// Rz(yaw) Ry(pitch) Rx(roll); what looks like an attitude but cannot be told is named by `remark`.
PoseColumns poseColumns(const Layout& layout);
/// Turns a pose in axes north, east, down, whose position is given as east, north, down [m], into
/// axes east, north, up; its attitude x y z w too. Nothing where they do not point down.
void eastNorthUp(const PoseColumns& columns, double p[3], double xyzw[4]);
/// The quaternion x y z w of Rz(yaw) Ry(pitch) Rx(roll), angles in [rad].
void quaternionOf(const double roll_pitch_yaw[3], double xyzw[4]);
/// Which order was taken where no header says it and habits differ; empty elsewhere.
std::string assumedOrder(const Layout& layout, const PoseColumns& columns);
/// Why a table that looks like one of poses holds none that can be used (latitude and longitude,
/// KITTI's matrices without stamps), and what to do; else empty.
std::string whyNoPoses(const Layout& layout);
/// A header for every column, and no remark that happens to have as many words: one of its names is
/// that of a time. Columns of such a table are not taken by their place.
bool namesAll(const Layout& layout);

struct ImuColumns {
  int stamp = 0;
  int gyro[3] = {1, 2, 3};
  int acc[3] = {4, 5, 6};
  bool named = false;     ///< the header said so
  bool turned = false;    ///< no header, but the first three are an accelerometer at rest
  bool by_units = false;  ///< names are not known, the units behind them tell which is which
  double gyro_unit = 1;   ///< [rad/s] of what the header says the numbers are in
  double acc_unit = 1;    ///< [m/s^2]
  int last() const;
};
/// By the names of the header; else by the units behind them, where they tell; else t, gyro,
/// accelerometer; or the accelerometer first where the size of the numbers says so.
ImuColumns imuColumns(const Layout& layout);

/// Three columns of one sensor, of a file that holds nothing else.
struct VectorColumns {
  int stamp = 0;
  int v[3] = {1, 2, 3};
  bool named = false;
  double unit = 1;  ///< [rad/s] or [m/s^2] of what the header says the numbers are in
  int last() const;
};
/// `plain`: columns called x, y, z alone will do.
VectorColumns gyroColumns(const Layout& layout, bool plain);
VectorColumns accelerometerColumns(const Layout& layout, bool plain);
/// The middle of the vectors' sizes in the rows at hand; 0 without any.
double medianNorm(const Layout& layout, const int columns[3]);

struct ImageColumns {
  int stamp = 0;
  int file = 1;  ///< -1: files are called after their stamps
  bool named = false;
  bool by_content = false;  ///< found by endings like .png
};
ImageColumns imageColumns(const Layout& layout);

/// A column that is called after a time; -1: there is none.
int namedStampColumn(const Layout& layout);
/// That, else one of dates or times of day, else 0, or 1 if the first column only counts and the
/// second is a stamp.
int stampColumn(const Layout& layout);
/// What is to be said of stamps that are no numbers: dates, and on which clock they are taken to
/// be; and of two times, which was taken. Empty: nothing.
std::string stampRemark(const Layout& layout, int column);
/// The column of the nanoseconds that belong to whole seconds in column `stamp` (`secs,nsecs`); -1:
/// there is none.
int nanosecondColumn(const Layout& layout, int stamp);
/// The unit of the stamps in column `index`.
UnitGuess stampUnit(const Layout& layout, int index, double typical_step_s);

}  // namespace vir::tables
