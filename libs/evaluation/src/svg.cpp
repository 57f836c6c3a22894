#include <cstdio>

#include "vir/core/markup.h"
#include "vir/evaluation/figure.h"

namespace vir::evaluation {
namespace {

std::string number(double v) {
  char text[48];
  std::snprintf(text, sizeof text, "%.1f", v);
  return text;
}

std::string hex(Color c) {
  char text[16];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", c.r & 255, c.g & 255, c.b & 255);
  return text;
}

class SvgCanvas : public Canvas {
 public:
  void polyline(const std::vector<Vec2>& points, Color color, double width) override {
    if (points.empty()) return;
    body_ += "<polyline fill=\"none\" stroke-linejoin=\"round\" stroke=\"" + hex(color) +
             "\" stroke-width=\"" + number(width) + "\" points=\"";
    for (const Vec2& p : points) body_ += number(p.x()) + "," + number(p.y()) + " ";
    body_ += "\"/>\n";
  }

  void dot(const Vec2& centre, double radius, Color color) override {
    body_ += "<circle cx=\"" + number(centre.x()) + "\" cy=\"" + number(centre.y()) + "\" r=\"" +
             number(radius) + "\" fill=\"" + hex(color) + "\"/>\n";
  }

  void polygon(const std::vector<Vec2>& outline, Color color, double opacity) override {
    if (outline.size() < 3) return;
    char share[16];
    std::snprintf(share, sizeof share, "%.2f", opacity);
    body_ += "<polygon stroke=\"none\" fill=\"" + hex(color) + "\" fill-opacity=\"" + share +
             "\" points=\"";
    for (const Vec2& p : outline) body_ += number(p.x()) + "," + number(p.y()) + " ";
    body_ += "\"/>\n";
  }

  void text(const Vec2& at, const std::string& text, double size, Anchor anchor, Color color,
            bool upward) override {
    static const char* const anchors[] = {"start", "middle", "end"};
    const std::string x = number(at.x()), y = number(at.y());
    body_ += "<text x=\"" + x + "\" y=\"" + y + "\" font-size=\"" + number(size) + "\" fill=\"" +
             hex(color) + "\" text-anchor=\"" + anchors[static_cast<int>(anchor)] + "\"";
    if (upward) body_ += " transform=\"rotate(-90 " + x + " " + y + ")\"";
    body_ += ">" + escapedMarkup(text) + "</text>\n";
  }

  const std::string& body() const { return body_; }

 private:
  std::string body_;
};

}  // namespace

std::string toSvgElement(const Figure& figure) {
  SvgCanvas canvas;
  draw(figure, &canvas);
  const std::string w = number(figure.width), h = number(figure.height);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + w + "\" height=\"" + h +
         "\" viewBox=\"0 0 " + w + " " + h +
         "\" font-family=\"Helvetica, Arial, sans-serif\">\n<rect width=\"100%\" height=\"100%\" "
         "fill=\"#ffffff\"/>\n" +
         canvas.body() + "</svg>\n";
}

std::string toSvg(const Figure& figure) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + toSvgElement(figure);
}

}  // namespace vir::evaluation
