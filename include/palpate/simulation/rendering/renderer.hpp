// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/simulation/rendering/image.hpp"

namespace palpate::simulation {

/// How OpenGL draws without a screen.
enum class RenderBackend { egl, osmesa };
std::string_view to_string(RenderBackend backend);

/// The first backend that gives an OpenGL context here; nothing if none does. Tried once for the
/// whole process. MUJOCO_GL=egl or osmesa in the environment leaves only that one.
std::optional<RenderBackend> working_render_backend();

/// Looks at a point from a distance.
struct Camera {
  Eigen::Vector3d lookat = Eigen::Vector3d(0, 0, 0.1);  ///< m, in the world
  double distance = 0.75;                               ///< m
  double azimuth_deg = 275;    ///< of the view's direction about z, from +x
  double elevation_deg = -16;  ///< negative: from above
};

/// A pose at which the object is drawn once more, see-through.
struct Ghost {
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  double opacity = 0.5;  ///< 0..1
};

/// Where the things that are drawn are.
struct DrawnState {
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  hand::JointVector joints;  ///< rad
  hand::MountPosition mount;
  double object_opacity = 1;  ///< 0..1; 0: the object is not drawn
  std::vector<Ghost> ghosts = {};
  std::string caption = {};  ///< ASCII, in the picture's upper left corner; several lines by \n
};

/// Draws the hand, an object and the table for people to look at; nothing estimates or acts on it.
///
/// Needs neither a World nor its physics. The same state gives the same picture. One thread at a
/// time may use a renderer; renderers of different threads do not disturb each other.
class Renderer {
 public:
  /// @param width, height  of the pictures, pixels, 16..4096
  /// @throws BadInput for a size out of range, or when no backend works here
  Renderer(const hand::Description& hand, const geometry::KnownObject& object, int width,
           int height);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// @throws BadInput for a state or a camera with a value that is not finite, for an opacity
  ///         outside 0..1, or for more than 500 ghosts
  Image render(const DrawnState& state, const Camera& camera = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::simulation
