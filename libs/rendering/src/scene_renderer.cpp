#include "vir/rendering/scene_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <stdexcept>

#include "ray_row.h"
#include "surfaces.h"
#include "vir/core/random.h"

namespace vir::rendering {
namespace {

/// A square's pyramid is this much wider than its pixels [px].
constexpr double kRim_px = 1.5;
constexpr std::uint16_t kNothing = 65535;
constexpr int kEdgeSamples = 16;
/// So many neighbouring pixels of a face share the size of their area on it.
constexpr int kRun = kLanes;

struct Tile {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< pixels [x0, x1)
  std::size_t begin = 0, end = 0;      ///< of `candidates`
  F3 dx{}, dy{};                       ///< change of the unit ray per pixel, in W
  bool whole = true;                   ///< every pixel has a ray
};

/// Points that all have different x and different y: an edge of any direction that moves by 1/16 of
/// a pixel changes the mean.
std::array<std::array<float, 2>, kEdgeSamples> edgePattern() {
  std::array<std::array<float, 2>, kEdgeSamples> out{};
  for (int k = 0; k < kEdgeSamples; ++k) {
    const int mirrored = ((k & 1) << 3) | ((k & 2) << 1) | ((k & 4) >> 1) | ((k & 8) >> 3);
    out[static_cast<std::size_t>(k)] = {
        (static_cast<float>(k) + 0.5F) / kEdgeSamples - 0.5F,
        (static_cast<float>(mirrored) + 0.5F) / kEdgeSamples - 0.5F};
  }
  return out;
}

}  // namespace

struct SceneRenderer::Impl {
  Impl(std::shared_ptr<const Scene> s, std::shared_ptr<const camera::CameraModel> c, int seed)
      : scene(std::move(s)),
        camera(std::move(c)),
        surfaces(*scene, seed),
        width(camera->calibration().width),
        height(camera->calibration().height) {
    makeRays();
    makeTiles();
    boxes.resize(scene->boxes().size());
    candidates.reserve(tiles.size() * 8);
    faces.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), kNothing);
  }

  void makeRays();
  void makeTiles();
  Vec3 rayNear(double x, double y, bool* good) const;
  /// Ready for tiles that hold any of the rows.
  void moveTo(const Pose& T_W_C, int from_row, int to_row);
  void findCandidates(Tile* tile);
  void loadRow(const Tile& tile, int y, Row* r) const;
  void trace(const Tile& tile, Row* r) const;
  void drawTile(const Tile& tile, float contrast, float weight, FloatImage* sum);
  VIR_WIDE void drawTileWide(const Tile& tile, float contrast, float weight, FloatImage* sum) {
    drawTile(tile, contrast, weight, sum);
  }
  static bool holds(const Tile& tile, int from_row, int to_row) {
    return tile.y0 < to_row && tile.y1 > from_row;
  }
  /// Grey levels of the first `n` rays.
  void shade(const Row& r, int n, const Tile& tile, float contrast, float* out) const;
  bool onEdge(int x, int y) const;
  void smoothEdges(const Tile& tile, float contrast, float weight, FloatImage* sum);
  VIR_WIDE void smoothEdgesWide(const Tile& tile, float contrast, float weight, FloatImage* sum) {
    smoothEdges(tile, contrast, weight, sum);
  }
  float overPixel(const Tile& tile, std::size_t pixel, float contrast) const;

  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const camera::CameraModel> camera;
  Surfaces surfaces;
  int width, height;
  std::array<std::vector<float>, 3> rays;  ///< unit, in C
  std::vector<char> has_ray;
  std::vector<Tile> tiles;
  std::vector<std::array<Vec3, 4>> corners;  ///< of the tiles' pyramids, in C
  std::vector<std::array<Vec3, 2>> slopes;   ///< of the tiles' rays per pixel, in C
  const std::array<std::array<float, 2>, kEdgeSamples> pattern = edgePattern();

  // Of the view being drawn.
  int top = 0, bottom = 0;  ///< rows [top, bottom)
  Mat3 R_W_C = Mat3::Identity();
  std::array<F3, 3> R{};
  Vec3 eye = Vec3::Zero();
  NearBox room;
  std::vector<NearBox> boxes;  ///< nearest first
  std::vector<std::uint16_t> candidates;
  std::vector<std::uint16_t> faces;
  std::vector<float> values;
  bool wide = hasWideVectors();
};

void SceneRenderer::Impl::makeRays() {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  for (auto& r : rays) r.assign(pixels, 0.0F);
  values.assign(pixels, 0.0F);
  has_ray.assign(pixels, 0);
  std::size_t k = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++k) {
      Vec3 b;
      if (!camera->unproject(Vec2(x, y), &b))
        b = Vec3::UnitZ();
      else
        has_ray[k] = 1;
      for (std::size_t a = 0; a < 3; ++a) rays[a][k] = static_cast<float>(b[static_cast<int>(a)]);
    }
  }
}

/// Also a little outside of the image.
Vec3 SceneRenderer::Impl::rayNear(double x, double y, bool* good) const {
  Vec3 b = Vec3::Zero();
  *good = camera->unproject(Vec2(x, y), &b) && *good;
  return b;
}

void SceneRenderer::Impl::makeTiles() {
  for (int y = 0; y < height; y += kTile) {
    for (int x = 0; x < width; x += kTile) {
      Tile t;
      t.x0 = x;
      t.y0 = y;
      t.x1 = std::min(width, x + kTile);
      t.y1 = std::min(height, y + kTile);
      const double l = x - kRim_px, r = t.x1 - 1 + kRim_px, u = y - kRim_px, d = t.y1 - 1 + kRim_px;
      const double mx = 0.5 * (l + r), my = 0.5 * (u + d);
      corners.push_back({rayNear(l, u, &t.whole), rayNear(r, u, &t.whole), rayNear(r, d, &t.whole),
                         rayNear(l, d, &t.whole)});
      const Vec3 dx = rayNear(mx + 1, my, &t.whole) - rayNear(mx - 1, my, &t.whole);
      const Vec3 dy = rayNear(mx, my + 1, &t.whole) - rayNear(mx, my - 1, &t.whole);
      slopes.push_back({0.5 * dx, 0.5 * dy});
      tiles.push_back(t);
    }
  }
}

void SceneRenderer::Impl::moveTo(const Pose& T_W_C, int from_row, int to_row) {
  top = from_row;
  bottom = to_row;
  R_W_C = T_W_C.R();
  eye = T_W_C.p;
  for (int r = 0; r < 3; ++r) R[static_cast<std::size_t>(r)] = toF3(R_W_C.row(r));
  room.low = toF3(scene->interior().low - eye);
  room.high = toF3(scene->interior().high - eye);
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const Box& b = scene->boxes()[k];
    boxes[k].low = toF3(b.low - eye);
    boxes[k].high = toF3(b.high - eye);
    boxes[k].index = static_cast<int>(k);
    boxes[k].distance = static_cast<float>((eye - eye.cwiseMax(b.low).cwiseMin(b.high)).norm());
  }
  std::sort(boxes.begin(), boxes.end(), [](const NearBox& a, const NearBox& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.index < b.index;
  });
  candidates.clear();
  for (Tile& t : tiles) {
    if (holds(t, top - 1, bottom + 1)) findCandidates(&t);
  }
}

/// Boxes that are not wholly outside of one side of the tile's pyramid.
void SceneRenderer::Impl::findCandidates(Tile* tile) {
  const auto index = static_cast<std::size_t>(tile - tiles.data());
  tile->dx = toF3(R_W_C * slopes[index][0]);
  tile->dy = toF3(R_W_C * slopes[index][1]);
  tile->begin = candidates.size();
  F3 side[4];
  for (std::size_t k = 0; k < 4; ++k) {
    side[k] = toF3(R_W_C * corners[index][k].cross(corners[index][(k + 1) % 4]));
  }
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const NearBox& b = boxes[k];
    const bool outside = tile->whole && std::any_of(side, side + 4, [&b](const F3& n) {
                           float most = 0;
                           for (std::size_t a = 0; a < 3; ++a)
                             most += n[a] > 0 ? n[a] * b.high[a] : n[a] * b.low[a];
                           return most < 0;
                         });
    if (!outside) candidates.push_back(static_cast<std::uint16_t>(k));
  }
  tile->end = candidates.size();
}

void SceneRenderer::Impl::loadRow(const Tile& tile, int y, Row* r) const {
  const int n = tile.x1 - tile.x0;
  const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                         static_cast<std::size_t>(tile.x0);
  const float *cx = rays[0].data() + at, *cy = rays[1].data() + at, *cz = rays[2].data() + at;
  for (int axis = 0; axis < 3; ++axis) {
    const F3& m = R[static_cast<std::size_t>(axis)];
    for (int k = 0; k < n; ++k) r->d[axis][k] = m[0] * cx[k] + m[1] * cy[k] + m[2] * cz[k];
    for (int k = n; k < kTile; ++k) r->d[axis][k] = r->d[axis][n - 1];
  }
  invert(r);
}

void SceneRenderer::Impl::trace(const Tile& tile, Row* r) const {
  meetRoom(room, r);
  for (std::size_t k = tile.begin; k < tile.end; ++k) {
    const NearBox& b = boxes[candidates[k]];
    // Nearest first: the rest lies behind what has been met.
    if (b.distance > farthest(*r)) return;
    meetBox(b, r);
  }
}

void SceneRenderer::Impl::shade(const Row& r, int n, const Tile& tile, float contrast,
                                float* out) const {
  for (int k = 0; k < n;) {
    // So many runs are worked on side by side; where there are fewer the last stands for the
    // others.
    int begin[kLanes + 1], face[kLanes], runs = 0;
    Floats d[3] = {}, t{};
    for (begin[0] = k; runs < kLanes && k < n; ++runs) {
      face[runs] = r.face[k];
      const int most = std::min(n, k + kRun);
      do ++k;
      while (k < most && r.face[k] == face[runs]);
      begin[runs + 1] = k;
    }
    for (int run = 0; run < kLanes; ++run) {
      const int from = std::min(run, runs - 1), middle = (begin[from] + begin[from + 1]) / 2;
      face[run] = face[from];
      for (int axis = 0; axis < 3; ++axis) d[axis][run] = r.d[axis][middle];
      t[run] = r.t[middle];
    }
    FaceView view[kLanes];
    surfaces.views(face, d, t, tile.dx.data(), tile.dy.data(), view);
    for (int run = 0; run < runs; ++run) {
      Floats relative[3] = {};
      // Of a shorter run the last point stands for those that are missing.
      for (int lane = 0; lane < kRun; ++lane) {
        const int at = std::min(begin[run] + lane, begin[run + 1] - 1);
        for (int axis = 0; axis < 3; ++axis) relative[axis][lane] = r.t[at] * r.d[axis][at];
      }
      const Floats grey = surfaces.radiance(view[run], relative, contrast);
      for (int at = begin[run]; at < begin[run + 1]; ++at) out[at] = grey[at - begin[run]];
    }
  }
}

void SceneRenderer::Impl::drawTile(const Tile& tile, float contrast, float weight,
                                   FloatImage* sum) {
  Row r;
  float grey[kTile];
  const int n = tile.x1 - tile.x0;
  // The rows beside it only tell whose edges meet there.
  const int from = std::max(tile.y0, top - 1), to = std::min(tile.y1, bottom + 1);
  for (int y = from; y < to; ++y) {
    const float w = y >= top && y < bottom ? weight : 0;
    loadRow(tile, y, &r);
    trace(tile, &r);
    shade(r, n, tile, contrast, grey);
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(tile.x0);
    for (int k = 0; k < n; ++k) {
      const std::size_t pixel = at + static_cast<std::size_t>(k);
      const bool ray = tile.whole || has_ray[pixel];
      faces[pixel] = ray ? static_cast<std::uint16_t>(r.face[k]) : kNothing;
      values[pixel] = ray ? grey[k] : 0;
      sum->pixels[pixel] += w * values[pixel];
    }
  }
}

bool SceneRenderer::Impl::onEdge(int x, int y) const {
  const auto w = static_cast<std::size_t>(width);
  const std::size_t at = static_cast<std::size_t>(y) * w + static_cast<std::size_t>(x);
  const std::uint16_t face = faces[at];
  if (face == kNothing) return false;
  return (x > 0 && faces[at - 1] != face) || (x + 1 < width && faces[at + 1] != face) ||
         (y > 0 && faces[at - w] != face) || (y + 1 < height && faces[at + w] != face);
}

/// Mean over the area of a pixel in which surfaces meet: each counts by its share of the area.
float SceneRenderer::Impl::overPixel(const Tile& tile, std::size_t pixel, float contrast) const {
  static_assert(kEdgeSamples == kTile, "one row of rays covers one pixel");
  Row r;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const float d = R[a][0] * rays[0][pixel] + R[a][1] * rays[1][pixel] + R[a][2] * rays[2][pixel];
    for (int k = 0; k < kTile; ++k) {
      const auto& s = pattern[static_cast<std::size_t>(k)];
      r.d[axis][k] = d + s[0] * tile.dx[a] + s[1] * tile.dy[a];
    }
  }
  invert(&r);
  trace(tile, &r);
  // Samples of one face are brought together; their mean lies on the face as well.
  int face[kTile + kLanes];
  float mean[kTile][3], distance[kTile], count[kTile];
  int faces_met = 0;
  for (int done = 0; done < kTile; ++faces_met) {
    face[faces_met] = r.face[done];
    float point[3] = {0, 0, 0}, t = 0;
    const int first = done;
    for (int k = done; k < kTile; ++k) {
      if (r.face[k] != face[faces_met]) continue;
      for (int axis = 0; axis < 3; ++axis) {
        point[axis] += r.t[k] * r.d[axis][k];
        std::swap(r.d[axis][k], r.d[axis][done]);
      }
      t += r.t[k];
      std::swap(r.t[k], r.t[done]);
      std::swap(r.face[k], r.face[done]);
      ++done;
    }
    count[faces_met] = static_cast<float>(done - first);
    distance[faces_met] = t / count[faces_met];
    for (int axis = 0; axis < 3; ++axis) mean[faces_met][axis] = point[axis] / count[faces_met];
  }
  float sum = 0;
  for (int first = 0; first < faces_met; first += kLanes) {
    FaceView view[kLanes];
    Floats d[3] = {}, t{};
    for (int k = 0; k < kLanes; ++k) {
      const int at = std::min(first + k, faces_met - 1);
      face[first + k] = face[at];
      for (int axis = 0; axis < 3; ++axis) d[axis][k] = mean[at][axis] / distance[at];
      t[k] = distance[at];
    }
    surfaces.views(face + first, d, t, tile.dx.data(), tile.dy.data(), view);
    for (int k = 0; k < kLanes && first + k < faces_met; ++k) {
      const float* const m = mean[first + k];
      const Floats point[3] = {allOf(m[0]), allOf(m[1]), allOf(m[2])};
      sum += count[first + k] * surfaces.radiance(view[k], point, contrast)[0];
    }
  }
  return sum / kEdgeSamples;
}

void SceneRenderer::Impl::smoothEdges(const Tile& tile, float contrast, float weight,
                                      FloatImage* sum) {
  for (int y = std::max(tile.y0, top); y < std::min(tile.y1, bottom); ++y) {
    for (int x = tile.x0; x < tile.x1; ++x) {
      if (!onEdge(x, y)) continue;
      const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                static_cast<std::size_t>(x);
      sum->pixels[pixel] += weight * (overPixel(tile, pixel, contrast) - values[pixel]);
    }
  }
}

SceneRenderer::SceneRenderer(std::shared_ptr<const Scene> scene,
                             std::shared_ptr<const camera::CameraModel> camera, int seed) {
  if (!scene || !camera) throw std::invalid_argument("SceneRenderer: no scene or no camera");
  impl_ = std::make_unique<Impl>(std::move(scene), std::move(camera), seed);
}
SceneRenderer::~SceneRenderer() = default;

void SceneRenderer::useNarrowVectors() { impl_->wide = false; }

const camera::CameraModel& SceneRenderer::camera() const { return *impl_->camera; }

void SceneRenderer::add(const Pose& T_W_C, double contrast, float weight, FloatImage* sum) {
  addRows(T_W_C, 0, impl_->height, contrast, weight, sum);
}

void SceneRenderer::addRows(const Pose& T_W_C, int from_row, int to_row, double contrast,
                            float weight, FloatImage* sum) {
  Impl& s = *impl_;
  if (sum->width != s.width || sum->height != s.height) {
    sum->width = s.width;
    sum->height = s.height;
    sum->pixels.assign(s.values.size(), 0.0F);
  }
  s.moveTo(T_W_C, std::max(0, from_row), std::min(s.height, to_row));
  if (!s.scene->interior().holds(s.eye)) return;
  s.surfaces.lookFrom(s.eye);
  const auto c = static_cast<float>(contrast);
  for (const Tile& t : s.tiles) {
    if (!s.holds(t, s.top - 1, s.bottom + 1)) continue;
    s.wide ? s.drawTileWide(t, c, weight, sum) : s.drawTile(t, c, weight, sum);
  }
  for (const Tile& t : s.tiles) {
    if (!s.holds(t, s.top, s.bottom)) continue;
    s.wide ? s.smoothEdgesWide(t, c, weight, sum) : s.smoothEdges(t, c, weight, sum);
  }
}

}  // namespace vir::rendering
