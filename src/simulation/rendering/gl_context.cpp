// SPDX-License-Identifier: Apache-2.0
#include "simulation/rendering/gl_context.hpp"

#include <cstdlib>
#include <stdexcept>
#include <vector>

namespace palpate::simulation {
namespace {

/// MuJoCo reads the same variable when it looks for OpenGL.
std::vector<RenderBackend> candidates() {
  const char* const value = std::getenv("MUJOCO_GL");
  const std::string_view wanted = value ? value : "";
  if (wanted == "egl") return {RenderBackend::egl};
  if (wanted == "osmesa") return {RenderBackend::osmesa};
  return {RenderBackend::egl, RenderBackend::osmesa};
}

}  // namespace

std::string_view to_string(RenderBackend backend) {
  return backend == RenderBackend::egl ? "EGL" : "OSMesa";
}

std::optional<RenderBackend> working_render_backend() {
  static const auto backend = []() -> std::optional<RenderBackend> {
    for (const RenderBackend candidate : candidates()) {
      if (make_gl_context(candidate)) return candidate;
    }
    return std::nullopt;
  }();
  return backend;
}

std::unique_ptr<GlContext> make_gl_context(RenderBackend backend) {
  return backend == RenderBackend::egl ? make_egl_context() : make_osmesa_context();
}

CurrentContext::CurrentContext(GlContext& context) : context_(context) {
  if (!context_.make_current()) throw std::runtime_error("the OpenGL context is lost");
}

}  // namespace palpate::simulation
