// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "simulation/rendering/gl_context.hpp"
#include "simulation/rendering/shared_library.hpp"

namespace palpate::simulation {
namespace {

// Of GL/osmesa.h, which few machines have.
using OsMesaHandle = struct osmesa_context*;
constexpr unsigned kRgba = 0x1908;
constexpr unsigned kUnsignedByte = 0x1401;

struct OsMesa {
  OsMesa() {
    library.find("OSMesaCreateContextExt", create);
    library.find("OSMesaDestroyContext", destroy);
    library.find("OSMesaMakeCurrent", make_current);
    found = create && destroy && make_current;
  }

  SharedLibrary library{"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};
  OsMesaHandle (*create)(unsigned format, int depth_bits, int stencil_bits, int accumulation_bits,
                         OsMesaHandle shared) = nullptr;
  void (*destroy)(OsMesaHandle context) = nullptr;
  unsigned char (*make_current)(OsMesaHandle context, void* buffer, unsigned type, int width,
                                int height) = nullptr;
  bool found = false;
};

const OsMesa& osmesa() {
  static const OsMesa functions;
  return functions;
}

class OsMesaContext final : public GlContext {
 public:
  explicit OsMesaContext(OsMesaHandle context) : context_(context) {}
  ~OsMesaContext() override { osmesa().destroy(context_); }

  bool make_current() override {
    return osmesa().make_current(context_, buffer_.data(), kUnsignedByte, kSide, kSide) != 0;
  }
  void release() override { osmesa().make_current(nullptr, nullptr, kUnsignedByte, 0, 0); }

 private:
  static constexpr int kSide = 16;  // of a window that nothing is drawn into, pixels
  OsMesaHandle context_;
  std::array<unsigned char, 4 * kSide * kSide> buffer_{};
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context() {
  if (!osmesa().found) return nullptr;
  OsMesaHandle handle = osmesa().create(kRgba, 24, 8, 0, nullptr);
  if (!handle) return nullptr;
  auto context = std::make_unique<OsMesaContext>(handle);
  if (!context->make_current()) return nullptr;
  context->release();
  osmesa().library.publish();
  return context;
}

}  // namespace palpate::simulation
