// SPDX-License-Identifier: Apache-2.0
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <vector>

#include "simulation/rendering/gl_context.hpp"
#include "simulation/rendering/shared_library.hpp"

namespace palpate::simulation {
namespace {

/// The functions of EGL that are used; `found` is false where the library is missing or too old.
struct Egl {
  Egl();

  SharedLibrary library{"libEGL.so.1", "libEGL.so"};
  decltype(eglGetProcAddress)* get_proc_address = nullptr;
  decltype(eglInitialize)* initialize = nullptr;
  decltype(eglBindAPI)* bind_api = nullptr;
  decltype(eglChooseConfig)* choose_config = nullptr;
  decltype(eglCreateContext)* create_context = nullptr;
  decltype(eglDestroyContext)* destroy_context = nullptr;
  decltype(eglMakeCurrent)* make_current = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display = nullptr;
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;  ///< null: no choice of devices
  bool found = false;
};

Egl::Egl() {
  library.find("eglGetProcAddress", get_proc_address);
  library.find("eglInitialize", initialize);
  library.find("eglBindAPI", bind_api);
  library.find("eglChooseConfig", choose_config);
  library.find("eglCreateContext", create_context);
  library.find("eglDestroyContext", destroy_context);
  library.find("eglMakeCurrent", make_current);
  if (!get_proc_address) return;
  get_platform_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
      get_proc_address("eglGetPlatformDisplayEXT"));
  query_devices =
      reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(get_proc_address("eglQueryDevicesEXT"));
  found = initialize && bind_api && choose_config && create_context && destroy_context &&
          make_current && get_platform_display;
}

const Egl& egl() {
  static const Egl functions;
  return functions;
}

class EglContext final : public GlContext {
 public:
  EglContext(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}
  // The display stays initialized: other contexts share it.
  ~EglContext() override { egl().destroy_context(display_, context_); }

  bool make_current() override {
    return egl().bind_api(EGL_OPENGL_API) &&
           egl().make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
  }
  void release() override {
    egl().make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

 private:
  EGLDisplay display_;
  EGLContext context_;
};

/// Displays without a screen: Mesa's own first, which needs no graphics card, then every device.
std::vector<EGLDisplay> displays() {
  std::vector<EGLDisplay> result = {
      egl().get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)};
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint count = 0;
  if (egl().query_devices) {
    egl().query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count);
  }
  for (EGLint i = 0; i < count; ++i) {
    result.push_back(egl().get_platform_display(EGL_PLATFORM_DEVICE_EXT,
                                                devices[static_cast<std::size_t>(i)], nullptr));
  }
  return result;
}

std::unique_ptr<GlContext> make_context(EGLDisplay display) {
  if (display == EGL_NO_DISPLAY || !egl().initialize(display, nullptr, nullptr)) return nullptr;
  if (!egl().bind_api(EGL_OPENGL_API)) return nullptr;
  constexpr std::array<EGLint, 5> kWanted = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE,
                                             EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!egl().choose_config(display, kWanted.data(), &config, 1, &count) || count == 0) {
    return nullptr;
  }
  EGLContext handle = egl().create_context(display, config, EGL_NO_CONTEXT, nullptr);
  if (handle == EGL_NO_CONTEXT) return nullptr;
  auto context = std::make_unique<EglContext>(display, handle);
  if (!context->make_current()) return nullptr;
  context->release();
  return context;
}

}  // namespace

std::unique_ptr<GlContext> make_egl_context() {
  if (!egl().found) return nullptr;
  for (EGLDisplay display : displays()) {
    if (auto context = make_context(display)) {
      egl().library.publish();
      return context;
    }
  }
  return nullptr;
}

}  // namespace palpate::simulation
