#include "output/png_canvas.h"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace vir::app {
namespace {

constexpr double kScale = 2;  // px of the picture per px of the figure

class PngCanvas : public evaluation::Canvas {
 public:
  PngCanvas(double width, double height)
      : image_(static_cast<int>(std::lround(height * kScale)),
               static_cast<int>(std::lround(width * kScale)), CV_8UC3, cv::Scalar(255, 255, 255)) {}

  void polyline(const std::vector<Vec2>& points, evaluation::Color color, double width) override {
    const int thickness = std::max(1, static_cast<int>(std::lround(width * kScale)));
    cv::polylines(image_, fixed(points), false, bgr(color), thickness, cv::LINE_AA, kFractionBits);
  }

  void polygon(const std::vector<Vec2>& outline, evaluation::Color color, double opacity) override {
    cv::Mat filled = image_.clone();
    cv::fillPoly(filled, std::vector<std::vector<cv::Point>>{fixed(outline)}, bgr(color),
                 cv::LINE_AA, kFractionBits);
    cv::addWeighted(filled, opacity, image_, 1 - opacity, 0, image_);
  }

  void dot(const Vec2& centre, double radius, evaluation::Color color) override {
    cv::circle(image_, point(centre * kScale), static_cast<int>(std::lround(radius * kScale)),
               bgr(color), cv::FILLED, cv::LINE_AA);
  }

  void text(const Vec2& at, const std::string& text, double size, Anchor anchor,
            evaluation::Color color, bool upward) override {
    if (text.empty()) return;
    // Capitals of this font are 21 px high at scale 1; those of the SVG's are 0.72 of its size.
    const double scale = size * kScale * 0.72 / 21;
    const int thickness = size > 16 ? 3 : 2;
    int base = 0;
    const cv::Size box = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, thickness, &base);
    const double shift = anchor == Anchor::start ? 0 : (anchor == Anchor::middle ? 0.5 : 1);
    if (!upward) {
      const Vec2 origin = at * kScale - Vec2(shift * box.width, 0);
      cv::putText(image_, text, point(origin), cv::FONT_HERSHEY_SIMPLEX, scale, bgr(color),
                  thickness, cv::LINE_AA);
      return;
    }
    cv::Mat label(box.height + base + 4, box.width + 4, CV_8UC3, cv::Scalar(255, 255, 255));
    cv::putText(label, text, {2, box.height + 2}, cv::FONT_HERSHEY_SIMPLEX, scale, bgr(color),
                thickness, cv::LINE_AA);
    cv::rotate(label, label, cv::ROTATE_90_COUNTERCLOCKWISE);
    const cv::Point corner = point(at * kScale - Vec2(box.height + 2, (1 - shift) * box.width + 2));
    const cv::Rect area = cv::Rect(corner, label.size()) & cv::Rect({0, 0}, image_.size());
    if (area.empty()) return;
    label(area - corner).copyTo(image_(area));
  }

  const cv::Mat& image() const { return image_; }

 private:
  static constexpr int kFractionBits = 4;

  static std::vector<cv::Point> fixed(const std::vector<Vec2>& points) {
    std::vector<cv::Point> out;
    for (const Vec2& p : points) out.push_back(point(p * kScale * (1 << kFractionBits)));
    return out;
  }
  static cv::Scalar bgr(evaluation::Color c) { return cv::Scalar(c.b, c.g, c.r); }
  static cv::Point point(const Vec2& v) {
    return {static_cast<int>(std::lround(v.x())), static_cast<int>(std::lround(v.y()))};
  }
  cv::Mat image_;
};

}  // namespace

void writePng(const evaluation::Figure& figure, const std::string& path) {
  PngCanvas canvas(figure.width, figure.height);
  draw(figure, &canvas);
  bool written = false;
  try {
    written = cv::imwrite(path, canvas.image());
  } catch (const cv::Exception&) {
    // OpenCV's own text names its source line, which helps nobody here.
  }
  if (!written) throw std::runtime_error("cannot write the plot to " + path);
}

}  // namespace vir::app
