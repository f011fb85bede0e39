// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "palpate/simulation/rendering/renderer.hpp"

namespace palpate::simulation {

/// An OpenGL context that draws into framebuffers of its own, without a screen.
class GlContext {
 public:
  virtual ~GlContext() = default;

  /// Makes it the calling thread's context, or takes it from that thread again.
  virtual bool make_current() = 0;
  virtual void release() = 0;
};

/// A context that has been current once; null where the libraries or the drivers lack it. Until
/// then the libraries are kept out of sight of MuJoCo, which takes OpenGL from what it can see.
std::unique_ptr<GlContext> make_egl_context();
std::unique_ptr<GlContext> make_osmesa_context();
std::unique_ptr<GlContext> make_gl_context(RenderBackend backend);

/// Keeps a context current for the length of a scope.
class CurrentContext {
 public:
  /// @throws std::runtime_error if the context is lost
  explicit CurrentContext(GlContext& context);
  ~CurrentContext() { context_.release(); }
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;

 private:
  GlContext& context_;
};

}  // namespace palpate::simulation
