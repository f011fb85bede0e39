// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/rendering/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "palpate/core/error.hpp"
#include "simulation/rendering/drawn_scene.hpp"
#include "simulation/rendering/gl_context.hpp"

namespace palpate::simulation {
namespace {

constexpr int kSmallest = 16, kLargest = 4096;  // pixels
constexpr int kMaxGeoms = 1000;
constexpr int kCollisionGroup = 3;  // of the hand's collision geoms in the MJCF

std::unique_ptr<GlContext> working_context() {
  const auto backend = working_render_backend();
  auto context = backend ? make_gl_context(*backend) : nullptr;
  if (!context) {
    throw BadInput(
        "nothing here draws without a screen: neither EGL nor OSMesa gives an OpenGL context "
        "(Debian: apt-get install libegl1 libgl1-mesa-dri libopengl0)");
  }
  return context;
}

void check_size(int width, int height) {
  if (std::min(width, height) < kSmallest || std::max(width, height) > kLargest) {
    throw BadInput(fmt::format("a picture of {} x {} pixels is not within {}..{}", width, height,
                               kSmallest, kLargest));
  }
}

mjvCamera to_mujoco(const Camera& camera) {
  if (!camera.lookat.allFinite() || !std::isfinite(camera.distance) || !(camera.distance > 0) ||
      !std::isfinite(camera.azimuth_deg) || !std::isfinite(camera.elevation_deg)) {
    throw BadInput(
        fmt::format("no camera looks from {} m, azimuth {} deg, elevation {} deg at ({}, {}, {})",
                    camera.distance, camera.azimuth_deg, camera.elevation_deg, camera.lookat.x(),
                    camera.lookat.y(), camera.lookat.z()));
  }
  mjvCamera result;
  mjv_defaultCamera(&result);
  Eigen::Vector3d::Map(result.lookat) = camera.lookat;
  result.distance = camera.distance;
  result.azimuth = camera.azimuth_deg;
  result.elevation = camera.elevation_deg;
  return result;
}

/// OpenGL's rows go up, a picture's go down.
void flip_rows(Image& image) {
  const auto row = 3 * static_cast<std::ptrdiff_t>(image.width);
  for (std::ptrdiff_t low = 0, high = image.height - 1; low < high; ++low, --high) {
    std::swap_ranges(image.rgb.begin() + low * row, image.rgb.begin() + (low + 1) * row,
                     image.rgb.begin() + high * row);
  }
}

/// MuJoCo's scene and its OpenGL objects, made and freed while the context is current.
struct Canvas {
  explicit Canvas(const mjModel& model) {
    mjv_defaultScene(&scene);
    mjr_defaultContext(&context);
    mjv_makeScene(&model, &scene, kMaxGeoms);
    mjr_makeContext(&model, &context, mjFONTSCALE_100);
    mjr_setBuffer(mjFB_OFFSCREEN, &context);
  }
  ~Canvas() {
    mjr_freeContext(&context);
    mjv_freeScene(&scene);
  }
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  mjvScene scene;
  mjrContext context;
};

mjvOption visible_things() {
  mjvOption options;
  mjv_defaultOption(&options);
  options.geomgroup[kCollisionGroup] = 0;
  std::fill(std::begin(options.tendongroup), std::end(options.tendongroup), mjtByte{0});
  std::fill(std::begin(options.sitegroup), std::end(options.sitegroup), mjtByte{0});
  return options;
}

}  // namespace

struct Renderer::Impl {
  Impl(const hand::Description& hand, const geometry::KnownObject& object, int w, int h)
      : width(w),
        height(h),
        scene(compose_drawn_scene(hand, object, w, h)),
        data(mj_makeData(scene.model.get())),
        gl(working_context()) {
    if (!data) throw std::bad_alloc();
    const CurrentContext current(*gl);
    canvas = std::make_unique<Canvas>(*scene.model);
  }
  ~Impl() {
    if (!gl->make_current()) return;  // what it held went with it
    canvas.reset();
    gl->release();
  }

  int width, height;
  DrawnScene scene;
  DataHandle data;
  std::unique_ptr<GlContext> gl;
  std::unique_ptr<Canvas> canvas;
};

Renderer::Renderer(const hand::Description& hand, const geometry::KnownObject& object, int width,
                   int height) {
  check_size(width, height);
  impl_ = std::make_unique<Impl>(hand, object, width, height);
}

Renderer::~Renderer() = default;

Image Renderer::render(const DrawnState& state, const Camera& camera) {
  Impl& impl = *impl_;
  mjvCamera view = to_mujoco(camera);
  pose_scene(impl.scene, state, *impl.data);
  const CurrentContext current(*impl.gl);
  const mjvOption options = visible_things();
  mjv_updateScene(impl.scene.model.get(), impl.data.get(), &options, nullptr, &view, mjCAT_ALL,
                  &impl.canvas->scene);
  draw_ghosts(impl.scene, state, impl.canvas->scene);
  const mjrRect area = {0, 0, impl.width, impl.height};
  mjr_render(area, &impl.canvas->scene, &impl.canvas->context);
  if (!state.caption.empty()) {
    mjr_overlay(mjFONT_NORMAL, mjGRID_TOPLEFT, area, state.caption.c_str(), nullptr,
                &impl.canvas->context);
  }
  Image image{impl.width, impl.height, {}};
  image.rgb.resize(3 * static_cast<std::size_t>(impl.width) *
                   static_cast<std::size_t>(impl.height));
  mjr_readPixels(image.rgb.data(), nullptr, area, &impl.canvas->context);
  flip_rows(image);
  return image;
}

}  // namespace palpate::simulation
